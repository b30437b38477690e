"""Messages of live hardware, and what is shown of them meanwhile."""

import json
import math
from dataclasses import asdict
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydrake.systems.primitives import PassThrough

from soft_gripper.extras.bench.live_tables import finger_table, needed_signals
from soft_gripper.extras.bench.messages import (
    MAX_MESSAGE_BYTES,
    MalformedError,
    count_of,
    decoded,
    encoded,
    select_numbers,
)
from soft_gripper.extras.bench.tally import CalibrationTally, StatusLine
from soft_gripper.extras.bench.watch import Watch
from soft_gripper.signals import describe

FIELDS = ["n", "a", "b"]
RESULTS = {"n": 3.0, "v": np.array([0.5, -1.25])}


@pytest.mark.parametrize("form", ["text", "float32", "float64"])
def test_numbers_without_names_come_back(form):
    assert decoded(encoded(RESULTS, form), form, FIELDS) == {"n": 3.0, "a": 0.5, "b": -1.25}


def test_null_is_a_sensor_that_was_not_read():
    found = decoded(b'{"a": null, "b": [1, null]}', "json", ())
    assert math.isnan(found["a"])
    assert math.isnan(found["b[1]"])
    assert json.loads(encoded({"a": np.array([np.nan])}, "json")) == {"a": [None]}


@pytest.mark.parametrize(
    ("message", "form"),
    [
        (b"", "json"),
        (b"nonsense", "json"),
        (b"[1, 2]", "json"),
        (b'{"a": "1"}', "json"),
        (b'{"a": true}', "json"),
        (b'{"a": NaN}', "json"),
        (b'{"a": 1e999}', "json"),
        (b'{"a": ' + b"9" * 400 + b"}", "json"),
        (b"[" * 50_000, "json"),
        (b'{"a": [[1]]}', "json"),
        (b" " * (MAX_MESSAGE_BYTES + 1), "json"),
        (b"\xff\xfe", "json"),
        (b"1,2", "text"),
        (b"1,2,3,4", "text"),
        (b"1,2,nan", "text"),
        (b"1,2,inf", "text"),
        (b"1,2,x", "text"),
        (b"1,2,1_0", "text"),
        (b"\xb2,2,3", "text"),
        (b"\0" * 11, "float32"),
        (np.array([1, 2, np.nan]).tobytes(), "float64"),
    ],
)
def test_malformed_messages(message, form):
    with pytest.raises(MalformedError):
        decoded(message, form, FIELDS)


@given(st.binary(max_size=200), st.sampled_from(["json", "text", "float32", "float64"]))
def test_no_message_does_more_than_be_malformed(message, form):
    try:
        found = decoded(message, form, FIELDS)
    except MalformedError:
        return
    assert not any(map(math.isinf, found.values()))


def test_fields_that_are_missing_and_numbers_that_do_not_count():
    with pytest.raises(MalformedError, match="no field 'c'"):
        select_numbers({"a": 1.0}, ["a", "c"])
    for value in (-1.0, 0.5, math.nan, math.inf, 2.0**60):
        with pytest.raises(MalformedError):
            count_of(value)


def watched(*counts):
    watch = Watch()
    return [watch.accept(count) for count in counts], watch.counts


@pytest.mark.parametrize(
    ("counts", "gaps", "expected"),
    [
        ([None, None], [0, 0], {"used": 2}),
        ([0, 1, 4, 3, 3, 4, 5], [0, 0, 2, None, None, None, 0], {"used": 4, "lost": 1, "late": 1, "repeated": 2}),
        # A device that restarts: from several readings in order it is known that the numbers go on there.
        *(([n, 0, 1, 2, 3], [0, None, None, 0, 0], {"used": 3, "restarts": 1, "repeated": 2}) for n in (5000, 500, 5)),
        # The sixth has a number far ahead: what it skips is not lost, but for the number that it hid.
        *(
            (
                [0, 1, 2, 3, 4, n, 6, 7, 8, 9, 10],
                [0, 0, 0, 0, 0, n - 5, None, None, 0, 0, 0],
                {"used": 9, "lost": 1, "late": 2, "restarts": 1},
            )
            for n in (12, 999, 10**6)
        ),
        # A number that cannot be right loses nothing; where others go on from it, the device counts from there.
        ([3, 4, 2**53 - 1, 6, 7], [0, 0, None, 1, 0], {"used": 4, "lost": 1, "malformed": 1}),
        ([4, *range(2**40, 2**40 + 4)], [0, None, None, 0, 0], {"used": 3, "malformed": 2, "restarts": 1}),
    ],
)
def test_numbers_of_readings_tell_what_is_missing(counts, gaps, expected):
    found, seen = watched(*counts)
    assert found == gaps
    assert {name: number for name, number in asdict(seen).items() if number} == expected


@given(st.lists(st.integers(0, 60), unique=True, min_size=1))
def test_every_reading_is_counted_once(order):
    """Used, late or lost: together all those between the first that came and the last, if it never began anew."""
    _, counts = watched(*order)
    assume(counts.restarts == 0)
    assert counts.used + counts.late + counts.repeated == len(order)
    assert counts.used + counts.late + counts.lost == max(order) - order[0] + 1
    assert counts.repeated == sum(count < order[0] for count in order)


NAN = np.nan


def port(size=1, meanings=()):
    return describe(PassThrough(size).get_output_port(), "1", meanings, **({"entry": range(size)} if size > 1 else {}))


KNOWN = {
    "left.tip_pose": port(3),
    "left.position_std": port(2),
    "left.transverse_force": port(),
    "left.transverse_force_std": port(),
    "left.contact_answer": port(meanings=("nothing touches", "touched here")),
    "left.contact_probability": port(),
    "left.contact_force_bounds": port(3),
    "left.is_far": port(meanings=("no", "far")),
    "left.state_distance": port(3),
    "right.tip_pose": port(3),
    "right.fault": port(meanings=("healthy", "dead")),
}
VALUES = {
    "left.tip_pose": [0.0123, 0.11, 0.2],
    "left.position_std": [0.0, 0.00042],
    "left.transverse_force": [0.5],
    "left.transverse_force_std": [0.04],
    "left.contact_answer": [1.0],
    "left.contact_probability": [0.1],
    "left.contact_force_bounds": [1.0, 2.0, 0.42],
    "left.is_far": [0.0],
    "left.state_distance": [0.1, 2.3, 0.0],
    "right.fault": [0.0],
}
OTHERS = {"left.transverse_force_std": [NAN], "left.contact_force_bounds": [1.0, 2.0, NAN], "left.is_far": [1.0]}


def cells(values, disagreeing=()):
    """Left and right of each row."""
    given = {name: np.array(value) for name, value in values.items()}
    _, head, *found = finger_table(["left", "right"], KNOWN, given, disagreeing)
    assert head == ["", "left", "right"]
    return {title: tuple(row) for title, *row in found}


def test_what_is_estimated_of_any_finger_has_a_row():
    """Without a band or bound that is not known; what is at fault or far from its calibration is marked."""
    assert set(needed_signals(["left", "right"], KNOWN)) == set(KNOWN)
    found = cells(VALUES)
    assert found == {
        "tip x, z [mm]": ("12.3, 110.0", "-"),
        "tip ± [mm]": ("0.42", "-"),
        "contact": ("touched here", "-"),
        "transverse force [N]": ("0.50 ± 0.04", "-"),
        "at most [N]": ("0.42", "-"),
        "health": ("-", "healthy"),
        "calibration": ("within, 2.3 spreads away", "-"),
    }
    others = cells(VALUES | OTHERS | {"right.fault": [1.0]}, ["right"])
    assert others == found | {
        "transverse force [N]": ("0.50", "-"),
        "at most [N]": ("not known", "-"),
        "health": ("-", ("dead", "bad")),
        "calibration": (("far, 2.3 spreads away", "bad"), "-"),
        "readings and drive": ("agree", ("disagree", "bad")),
    }
    assert {cell for row in cells({}).values() for cell in row} == {"-"}


LINE_RESULTS = {
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
    assert StatusLine(BENCH, "kPa", None).line(LINE_RESULTS, 61.25) == f"   61.2 s  live   {LINE}"
    assert "stale" in StatusLine(BENCH, "kPa", None).line(LINE_RESULTS | {"stale": 1.0}, 0.0)


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
