"""Steady states of a finger: their pressures, turns and samples."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.runs.scores.poses import held_samples, held_steps, recorded_pose_table
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ["pressure.steps.all=[-40e3, 200e3]", "pressure.settle=0.1", "pressure.hold_samples=10"]


def test_a_row_of_a_finger_in_space_has_its_turns_in_every_way() -> None:
    """A chamber on either side, alone: mirror images, each bent as far as the other and sideways the other way."""
    steps = ["pressure.steps={'finger::left': [60e3, 0.0], 'finger::right': [0.0, 60e3], 'finger::inner': [0.0]}"]
    station = make_station(load_scenario("three_chambers", [*steps, "pressure.settle=0.9"]))
    left, right = recorded_pose_table("chambers", station, run_station(station))
    assert left.sideways_angle_deg > 10
    assert right.sideways_angle_deg == pytest.approx(-left.sideways_angle_deg, rel=0.02)
    assert right.bend_angle_deg == pytest.approx(left.bend_angle_deg, rel=0.02)


def test_a_finger_that_twists_without_bending_sideways_has_no_sideways_angle() -> None:
    ways = [f"models.{side}_finger.fingers.all.yields=bending twist" for side in ("left", "right")]
    station = make_station(load_scenario("free_bending", [*SHORT, *ways]))
    recording = run_station(station)
    twist = recording["left_finger.true_twist_angles"]
    twist[:] = np.radians(2.0) / twist.sizes["joint"]
    row = recorded_pose_table("twisted", station, recording)[0]
    assert (row.sideways_angle_deg, row.twist_angle_deg) == (0.0, pytest.approx(2.0))


def test_a_finger_with_fewer_steps_holds_its_last_pressure() -> None:
    steps = "pressure.steps={left_finger: [10e3, 20e3, 30e3], right_finger: [40e3, 50e3]}"
    station = make_station(load_scenario("free_bending", [steps]))
    held = {finger.name: [step.pressure_kpa for step in held_steps("", station, finger)] for finger in station.fingers}
    assert held == {"left_finger": [10, 20, 30], "right_finger": [40, 50, 50]}


def test_a_controlled_finger_begins_at_its_pressure_and_keeps_no_other() -> None:
    """There are as many rows as set points, whatever pressures are listed."""
    station = make_station(
        load_scenario("tip_distance_steps", ["control.set_points=[0.06, 0.05, 0.04]", "pressure.steps={all: [10e3]}"])
    )
    (step, *others) = held_steps("", station, station.fingers[0])
    assert [each.pressure_kpa for each in others] == [step.pressure_kpa] * 2


@pytest.mark.slow
@pytest.mark.parametrize("time_step", [0.01, 0.0])
def test_a_held_step_knows_nothing_of_the_next_one(time_step):
    """The pressure of every held sample is that of its own step, the last one included."""
    steps = ["pressure.steps.all=[60e3, 120e3, -30e3]", "pressure.hold_samples=10"]
    station = make_station(load_scenario("free_bending", [*steps, f"plant_config.time_step={time_step}"]))
    recording = run_station(station)
    for finger in ("left_finger", "right_finger"):
        pressure = held_samples(station.scenario, recording, f"{finger}.pressure")
        np.testing.assert_allclose(pressure, np.tile([[60e3], [120e3], [-30e3]], (1, 10)), atol=1.0)
