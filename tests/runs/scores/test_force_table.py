"""Force tables: averages of what the blocks put out in the held steps, for any number of sensors."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.runs.scores.external_torques import force_table
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = ["pressure.steps.all=[60e3, 120e3, -30e3]", "pressure.hold_samples=10"]
FINGERS = ("left_finger", "right_finger")


def recorded(name, *overrides):
    station = make_station(load_scenario(name, [*STEPS, *overrides]))
    return station, run_station(station)


def column(rows, name, *shape):
    """Of the first finger."""
    return np.array([getattr(row, name) for row in rows if row.finger == FINGERS[0]]).reshape(shape)


@pytest.fixture(scope="module")
def obstructed():
    """The obstructed finger, the first of two, with four sensors per side, and its recording."""
    return recorded("obstructed_inside")


@pytest.mark.slow
@pytest.mark.parametrize("sections", [4, 2])
def test_holds_what_the_blocks_put_out(obstructed, sections):
    """For the sensors of the run itself, and for others by a run with those."""
    rows = force_table("obstructed", *obstructed, [sections])
    station, recording = obstructed if sections == 4 else recorded("obstructed_inside", f"sensor.sections={sections}")
    for name, signal in (("estimated_nm", "external_torque"), ("true_nm", "true_external_torque")):
        by_blocks = held_samples(station.scenario, recording, f"{FINGERS[0]}.{signal}").mean(axis=1)
        np.testing.assert_allclose(column(rows, name, 3, 12), by_blocks, atol=1e-6)
        assert np.abs(by_blocks).max() > 0.05


def test_a_row_for_every_finger_number_of_sections_step_and_joint():
    rows = force_table("free", *recorded("free_bending", "pressure.settle=0.01"), [1, 3])
    assert [(r.scenario, r.finger, r.estimator, r.nominal, r.sections, r.pressure_kpa, r.joint) for r in rows] == [
        ("free", finger, "arcs", "as simulated", sections, pressure, joint)
        for finger in FINGERS
        for sections in (1, 3)
        for pressure in (60.0, 120.0, -30.0)
        for joint in range(12)
    ]


@pytest.mark.slow
@pytest.mark.parametrize("time_step", [0.01, 0.0])
def test_a_held_step_knows_nothing_of_the_next_one(time_step):
    """The pressure of every held sample is that of its own step, the last one included."""
    station, recording = recorded("free_bending", f"plant_config.time_step={time_step}")
    for finger in FINGERS:
        pressure = held_samples(station.scenario, recording, f"{finger}.pressure")
        np.testing.assert_allclose(pressure, np.tile([[60e3], [120e3], [-30e3]], (1, 10)), atol=1.0)
