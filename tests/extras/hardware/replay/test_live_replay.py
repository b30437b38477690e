"""A recorded trial of hardware, sent to a live session at its own rate, gives the estimates of its offline replay."""

from dataclasses import replace

import numpy as np
import pytest
from hardware_files import published
from live_links import feed, pseudo_terminal, udp

from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import BenchDriver
from soft_gripper.extras.hardware.bench_schema import described
from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.extras.hardware.replay.arm_estimation import PERIOD, arm_recording
from soft_gripper.extras.hardware.replay.held_out import replay_recordings
from soft_gripper.scenario.scenario_file import load_scenario

ROW, SAMPLES = "spline 2", 200
ANGLES = "arm.estimated_joint_angles"
# The drive of the recorded arm is fitted as a matrix, which no scenario has: here is an estimator that needs none.
SCENARIO = """
models:
- { name: arm, file: "package://soft_gripper/recordings/two_segment_arm.urdf" }
gravity: [0, 0, 9.81]  # the arm hangs down, along z of its base
sensor: { sections: 2, period: 0.02 }
estimator: { type: spline }
"""


def made_up(arms):
    return arms[0], arms[1:]


def recorded(_):
    files = [published("two_segment_arm") / f"trial_{i}.txt" for i in (1, 2, 3)]
    first, *others = (arm_recording(each) for each in find_recordings(files, "two_segment_arm", None))
    return first, others


@pytest.mark.slow
@pytest.mark.parametrize("trial", [made_up, recorded])
def test_a_recorded_trial_over_every_link(trial, arms, arm_finger, tmp_path):
    arm, others = trial(arms)
    replay = replay_recordings([arm], others, {ROW: ("spline", 2)}, arm_finger, np.array([0.0, 0.0, 9.81]))
    signals = replay.replayed[0].signals
    offline = signals[f"{ROW}.estimated_joint_angles"].values[1 : SAMPLES + 1]
    readings = signals[f"{ROW}.strain"].values[1 : SAMPLES + 1].reshape(len(offline), -1)
    messages = [{"count": float(i), "time": PERIOD * i, "arm.strain": each} for i, each in enumerate(readings)]
    (tmp_path / "arm.yaml").write_text(SCENARIO, encoding="utf-8")
    for link in (udp, pseudo_terminal):
        results = []
        with link() as (source, send):
            bench = Bench(load_scenario(tmp_path / "arm.yaml"))
            pressures = {name: np.zeros(size) for name, size in bench.inputs.items() if name != "arm.strain"}
            config = replace(described(bench.inputs, "test"), send=[ANGLES])
            driver = BenchDriver(bench, config, source, lambda _, found: results.append(found))  # noqa: B023
            feed(driver, send, [message | pressures for message in messages], PERIOD)
        found = {int(each["count"]): each[ANGLES] for each in results if ANGLES in each and each["age"] == 0}
        assert len(found) == driver.counts.used == SAMPLES
        for count, angles in found.items():
            np.testing.assert_array_equal(angles, offline[count])
