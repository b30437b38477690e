"""The grip control in closed loop: how it follows its steps, at the limits of its pressure, and on an object."""

import numpy as np
import pytest

from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.step_table import step_table

HOLD = 4.0
GAINS = "control.gains={kp: 7.0e4, ki: 6.7e6, kd: 400}"


def run(name, *overrides):
    station = make_station(load_scenario(name, list(overrides)))
    return station, run_station(station)


def part(recording, signal, begin, end):
    time = recording.data["time"].values
    return recording[signal].values[(time > begin) & (time <= end + 1e-9)]


@pytest.fixture(scope="module")
def shipped():
    return run("tip_distance_steps")


def test_every_step_is_followed(shipped):
    table = step_table(*shipped)
    sizes = [row.to_mm - row.from_mm for row in table]
    assert min(sizes) < -35
    assert max(sizes) > 35
    for row in table:
        assert 9.9 < abs(row.to_mm - row.from_mm) < 40.1
        assert row.overshoot_percent <= 5
        assert row.settling_s <= 1
        assert abs(row.steady_error_estimated_mm) <= 0.2
        assert abs(row.steady_error_true_mm) <= 1


@pytest.mark.parametrize(("signal", "ripple"), [("grip.distance", 1e-5), ("left_finger.pressure", 20.0)])
def test_nothing_oscillates_three_seconds_after_a_step(shipped, signal, ripple):
    station, recording = shipped
    for step in range(station.scenario.steps):
        assert np.ptp(part(recording, signal, step * HOLD + 3, (step + 1) * HOLD)) < ripple


def test_signals_are_recorded_with_units(shipped):
    station, recording = shipped
    assert [recording[f"grip.{name}"].attrs["units"] for name in ("set_point", "distance")] == ["m", "m"]
    steps = [part(recording, "grip.set_point", step * HOLD, (step + 0.9) * HOLD) for step in range(9)]
    assert [set(step) for step in steps] == [{point} for point in station.scenario.control.set_points]


def out_of_reach(tracking_time):
    overrides = ("control.set_points=[0.08, 0.3, 0.08]", f"control.gains.tracking_time={tracking_time}")
    _, recording = run("tip_distance_steps", *overrides)
    return recording


def test_recovers_from_a_set_point_out_of_reach():
    recording = out_of_reach(0.1)
    minimum = load_scenario("tip_distance_steps").pressure.minimum
    assert (part(recording, "left_finger.pressure_command", 5, 8) == minimum).all()
    assert np.abs(part(recording, "grip.distance", 9, 12) - 0.08).max() < 0.02 * 0.07


def test_does_not_recover_without_back_calculation():
    recording = out_of_reach(1e9)
    assert np.abs(part(recording, "grip.distance", 9, 12) - 0.08).min() > 0.02


def test_a_gripped_object_brings_the_pressure_to_its_limit():
    station, recording = run("box_grasp", "control.set_points=[0.06, 0.02]", f"control.hold={HOLD}", GAINS)
    pressure = part(recording, "left_finger.pressure", 7, 8)
    np.testing.assert_allclose(pressure, station.scenario.pressure.maximum, rtol=1e-3)
    assert (part(recording, "left_finger.pressure_command", 7, 8) == station.scenario.pressure.maximum).all()
    # The box creeps through a frictional grip: a drift, but no swing.
    distance = part(recording, "grip.distance", 6, 8)
    swing = np.minimum(np.diff(distance).clip(min=0).sum(), -np.diff(distance).clip(max=0).sum())
    assert swing < 1e-4
    assert np.isfinite(recording["plant.state"].values).all()


def test_one_finger_is_refused():
    scenario = load_scenario("free_bending", ["control.set_points=[0.08]"])
    scenario.models = scenario.models[:1]
    with pytest.raises(InputError, match="two fingers"):
        make_station(scenario)
