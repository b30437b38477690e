"""Errors of sensors in a diagram: what estimation gets, what stays known, and what a seed fixes."""

import numpy as np
import pytest
from own_blocks import WarmSensor
from pydrake.systems.framework import LeafSystem
from pydrake.systems.primitives import ConstantVectorSource
from refusals import refused

from soft_gripper.diagrams.simulation import run_station, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ["pressure.steps.all=[0, 60e3]", "pressure.settle=0.2", "pressure.hold_samples=5"]
REALISTIC = "sensor.errors.preset=realistic"
PRESSURE = "sensor.pressure_errors={gain_error: 0.02, offset: 500.0, noise: 50.0}"


def short(*overrides, name="free_bending"):
    return load_scenario(name, [*SHORT, *overrides])


@pytest.fixture(scope="module")
def ideal():
    return simulate(short())


@pytest.fixture(scope="module")
def disturbed():
    return simulate(short(REALISTIC, PRESSURE, "sensor.seed=5"))


def test_what_is_measured_is_disturbed_as_much_as_is_asked_for(disturbed):
    error = (disturbed["left_finger.strain"] - disturbed["left_finger.ideal_strain"]).values
    assert disturbed["left_finger.strain"].dims == disturbed["left_finger.ideal_strain"].dims
    assert np.diff(error[2:], axis=0).std() == pytest.approx(0.002 * np.sqrt(2), rel=0.1)
    error = (disturbed["left_finger.sampled_pressure"] - disturbed["left_finger.ideal_pressure"]).values
    assert 20 < np.diff(error[2:25], axis=0).std() < 120
    assert disturbed["left_finger.sampled_pressure"].attrs["units"] == "Pa"


def test_a_seed_makes_a_run_reproducible(disturbed):
    """In another station, and in the same one again; each finger has a stream of its own."""
    station = make_station(short(REALISTIC, PRESSURE, "sensor.seed=5"))
    for again in (run_station(station), run_station(station)):
        for name in ("strain", "sampled_pressure", "external_torque"):
            np.testing.assert_array_equal(again[f"right_finger.{name}"], disturbed[f"right_finger.{name}"])
    left, right = (disturbed[f"{f}.strain"] - disturbed[f"{f}.ideal_strain"] for f in ("left_finger", "right_finger"))
    assert abs(np.corrcoef(left.values[1:, 0, 0], right.values[1:, 0, 0])[0, 1]) < 0.5


def test_errors_of_one_kind_leave_the_other_ideal(ideal):
    pressure = simulate(short(PRESSURE))
    np.testing.assert_array_equal(pressure["left_finger.strain"], ideal["left_finger.strain"])
    assert "left_finger.ideal_strain" not in pressure.data
    strain = simulate(short(REALISTIC))
    np.testing.assert_array_equal(strain["left_finger.sampled_pressure"], ideal["left_finger.sampled_pressure"])


def test_a_sensor_of_the_users_is_disturbed_too():
    """What it puts out besides is as it was."""
    recording = run_station(make_station(short("sensor.errors.offset=0.01"), make_sensor=WarmSensor))
    error = (recording["left_finger.strain"] - recording["left_finger.ideal_strain"]).values[1:]
    np.testing.assert_allclose(error, error[:1].repeat(len(error), axis=0), rtol=0, atol=1e-12)
    assert 0.002 < error[0].std() < 0.03
    assert "left_finger.warmth" in recording.data


class Peeping(LeafSystem):
    """An estimator that asks for the truth."""

    def __init__(self):
        super().__init__()
        self.DeclareVectorInputPort("ideal_strain", 8)
        self.DeclareVectorOutputPort("estimated_joint_angles", 12, lambda context, output: None)


def test_estimation_cannot_ask_for_the_truth():
    with refused("input port", "ideal_strain"):
        make_station(short(REALISTIC), make_estimator=lambda layout, gravity, period: Peeping())


def test_a_sensor_with_other_readings_cannot_be_disturbed():
    with refused("output ports", {"y0": 1}):
        make_station(short(REALISTIC), make_sensor=lambda layout, period: ConstantVectorSource([0.0]))
