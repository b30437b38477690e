"""What is taken of a run: touched fingers, and samples from the held part of every step."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.hardware.recorded_run import RecordedRun
from soft_gripper.extras.placement.samples import held_fingers
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = ["pressure.steps.all=[0, 60e3]", "pressure.settle=0.5", "pressure.hold_samples=5"]


@pytest.fixture(scope="module")
def run():
    """Runs a scenario in two short steps."""

    def run_scenario(name):
        station = make_station(load_scenario(name, STEPS))
        return RecordedRun(run_station(station), station.scenario, station.fingers)

    return run_scenario


def test_only_touched_fingers_count(run):
    """The peg is in the way of the left finger."""
    obstructed = run("obstructed_inside")
    (held,) = held_fingers("obstructed_inside", obstructed)
    recorded = obstructed.recording["left_finger.sampled_joint_angles"].values
    np.testing.assert_array_equal(held.q, recorded)


def test_where_nothing_is_touched_all_count(run):
    free = run("free_bending")
    left, right = held_fingers("free_bending", free)
    times = free.recording["time"].values[left.held]
    np.testing.assert_allclose(times, [0.51, 0.55, 1.06, 1.10], atol=1e-9)
    np.testing.assert_allclose(left.pressure[left.held], np.repeat([0, 60e3], 2), atol=10)
    np.testing.assert_allclose(left.gravity, 9.81, atol=1e-9)  # it hangs
    assert (left.period, left.layout.sections) == (0.01, 4)
    np.testing.assert_allclose(left.q[left.held], right.q[right.held], atol=1e-6)
