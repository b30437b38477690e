"""What `live` says meanwhile: a line of what is known, and whether calibrated fingers agree with their calibration."""

from types import SimpleNamespace

import numpy as np

from soft_gripper.extras.bench.tally import CalibrationTally, StatusLine

RESULTS = {
    "stale": 0.0,
    "lost": 3.0,
    "left.tip_pose": np.array([0.0123, 0.11, 0.2]),
    "left.transverse_force": np.array([0.5]),
    "left.transverse_force_std": np.array([np.nan]),
    "left.is_far": np.array([1.0]),
    "left.pressure_command": np.array([12.5]),
}
BENCH = SimpleNamespace(quantities={"left": "left.strain", "right": "right.strain"})
LINE = "left: tip 12.3, 110.0 mm, 0.50 N, command 12.5 kPa, FAR from its calibration | right: - | 3 lost"


def test_the_line_has_what_is_known_of_every_finger():
    assert StatusLine(BENCH, "kPa", None).line(RESULTS, 61.25) == f"   61.2 s  live   {LINE}"
    assert "stale" in StatusLine(BENCH, "kPa", None).line(RESULTS | {"stale": 1.0}, 0.0)


class Bench:
    """A calibrated finger, whose distances are given."""

    def __init__(self):
        self.period, states = 0.01, SimpleNamespace(disagreement=0.2)
        self.layouts = {"left": SimpleNamespace(calibrated=states)}
        self.apart, self.far = 0.0, 0.0

    def read(self, names):
        return {"left.disagreement": np.array([self.apart]), "left.is_far": np.array([self.far])}


def test_readings_that_never_come_near_the_calibration_are_said_once():
    bench = Bench()
    counts, bench.apart = CalibrationTally(bench), 0.3
    said = [line for _ in range(1000) for line in counts.note()]
    assert counts.disagreeing == ["left"]
    (line,) = said
    assert "readings and drive of left disagree" in line
    counts.restart()
    bench.apart = 0.1
    assert not [*counts.note()]
    assert counts.disagreeing == []


def test_what_is_far_is_summed_up():
    bench = Bench()
    counts = CalibrationTally(bench)
    assert not [*counts.lines()]
    for bench.far in [0.0] * 3 + [1.0]:
        list(counts.note())
    assert [*counts.lines()] == ["left: 25 % of the readings are far from its calibration, where bands are wider"]
