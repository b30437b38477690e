"""The grip control in closed loop: how it follows its steps, at the limits of its pressure, and on an object."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from refusals import refused

from soft_gripper.control.pid_controller import PidGains
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring.grip_control import GripControl, Supply, allocation
from soft_gripper.load.force_estimator import SAMPLES
from soft_gripper.load.opening import Gripper
from soft_gripper.runs.scores.steps import step_table
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import ControlConfig

pytestmark = pytest.mark.slow

HOLD = 4.0
GAINS = "control.gains={kp: 7.0e4, ki: 6.7e6, kd: 400}"
TORQUE_GAINS = "control.torque_gains={kp: 2.0e5, ki: 4.0e6}"
FORCE_GAINS = "control.force_gains={kp: 2.0e4, ki: 4.0e5}"
GRIPPER = Gripper((RigidTransform(), RigidTransform(RollPitchYaw(0, 0, np.pi), [0.09, 0, 0])))
FINGERS = {"first": 3, "second": 4}  # joints


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
    assert shipped[1]["grip.set_point"].attrs["units"] == "m"
    sizes = [row.to_mm - row.from_mm for row in table]
    assert min(sizes) < -35
    assert max(sizes) > 35
    for row in table:
        assert 9.9 < abs(row.to_mm - row.from_mm) < 40.1
        assert row.overshoot_percent <= 5
        assert row.settling_s <= 1
        assert abs(row.steady_error_estimated_mm) <= 0.2
        assert abs(row.steady_error_true_mm) <= 1


def out_of_reach(tracking_time):
    overrides = ("control.set_points=[0.08, 0.3, 0.08]", f"control.gains.tracking_time={tracking_time}")
    _, recording = run("tip_distance_steps", *overrides)
    return recording


def test_recovers_from_a_set_point_out_of_reach():
    recording = out_of_reach(0.1)
    minimum = load_scenario("tip_distance_steps").pressure.minimum
    assert (part(recording, "left_finger.pressure_command", 5, 8) == minimum).all()
    assert np.abs(part(recording, "grip.opening", 9, 12) - 0.08).max() < 0.02 * 0.07


def test_a_gripped_object_brings_the_pressure_to_its_limit():
    station, recording = run("box_grasp", "control.set_points=[0.06, 0.02]", f"control.hold={HOLD}", GAINS)
    pressure = part(recording, "left_finger.pressure", 7, 8)
    np.testing.assert_allclose(pressure, station.scenario.pressure.maximum, rtol=1e-3)
    assert (part(recording, "left_finger.pressure_command", 7, 8) == station.scenario.pressure.maximum).all()
    # The box creeps through a frictional grip: a drift, but no swing.
    opening = part(recording, "grip.opening", 6, 8)
    swing = np.minimum(np.diff(opening).clip(min=0).sum(), -np.diff(opening).clip(max=0).sum())
    assert swing < 1e-4
    assert np.isfinite(recording["plant.state"].values).all()


@pytest.mark.parametrize("limit", [0.03, 0.05])
def test_a_grip_closes_until_it_detects_the_torque_limit(limit):
    """The set point is inside the box: the limit is what ends the grip, in truth too, and long before the supply."""
    overrides = ("control.set_points=[0.06, 0.02]", "control.hold=2", GAINS, TORQUE_GAINS)
    station, recording = run("box_grasp", *overrides, f"control.torque_limit={limit}")
    estimated = recording["grip.torque"].values[SAMPLES:]  # before, nothing is estimated
    of_fingers = [recording[f"{finger.name}.true_external_torque"].values[:, 0] for finger in station.fingers]
    truth = -np.mean(of_fingers, axis=0)
    assert estimated.max() < 1.02 * limit
    assert truth.max() < 1.02 * limit
    assert estimated[-1] == pytest.approx(limit, rel=0.01)
    assert truth[-1] == pytest.approx(limit, rel=0.01)
    assert recording["left_finger.pressure"].values.max() < 0.6 * station.scenario.pressure.maximum


@pytest.mark.parametrize("limit", [0.4, 0.8])
def test_a_grip_closes_until_it_estimates_the_force_limit(limit):
    """And holds that: in the direction of closing, in truth too."""
    exact = "estimator.uncertainty.bend_per_pressure=0.005"
    overrides = ("control.set_points=[0.06, 0.02]", "control.hold=2", GAINS, FORCE_GAINS, exact)
    station, recording = run("box_grasp", *overrides, f"control.force_limit={limit}", "estimator.type=contact")
    estimated = recording["grip.force"].values
    truth = recording.forces().data["true_closing"].mean("finger").values
    assert recording["grip.force"].attrs["units"] == "N"
    assert estimated[-1] == pytest.approx(limit, rel=0.01)
    assert truth[-1] == pytest.approx(limit, rel=0.05)
    assert truth.max() < 1.1 * limit
    assert recording["left_finger.pressure"].values.max() < 0.6 * station.scenario.pressure.maximum


def test_a_force_limit_needs_an_estimator_of_contact():
    overrides = ("control.set_points=[0.06]", GAINS, FORCE_GAINS, "control.force_limit=0.5")
    with refused("force_limit", 0.5):
        make_station(load_scenario("box_grasp", list(overrides)))


BOUND = ("control.force_limit=0.5", "control.force_bound=true", FORCE_GAINS)


def test_a_bound_needs_contact_detection():
    overrides = (
        "control.set_points=[0.06]",
        GAINS,
        *BOUND,
        "estimator.type=contact",
        "estimator.contact_threshold=null",
    )
    with refused("force_bound", True):
        make_station(load_scenario("box_grasp", list(overrides)))


MAXIMUM = 5e3  # Pa


def grip_control(**control):
    """Alone, for fingers of 3 and 4 joints; and what it puts out at a set point, bends of the tips, and torques."""
    config = ControlConfig(gains=PidGains(kp=1e5), torque_gains=PidGains(kp=1e6), **control)
    return GripControl(GRIPPER, FINGERS, config, Supply(-60e3, MAXIMUM, 0.01))


def evaluate(control, set_point, bends, torques):
    context = control.CreateDefaultContext()
    control.GetInputPort("set_point").FixValue(context, [set_point])
    for which, bend, torque in zip(("first", "second"), bends, torques, strict=True):
        control.GetInputPort(f"{which}.tip_pose").FixValue(context, [bend, 0.1, 0.0])
        control.GetInputPort(f"{which}.external_torque").FixValue(context, torque)
    return {name: control.GetOutputPort(name).Eval(context)[0] for name in ("pressure", "opening", "torque")}


def test_torque_is_what_opens_the_fingers_at_their_bases():
    outputs = evaluate(grip_control(), 0.05, (0.01, 0.02), ([-0.03, 9, 9], [-0.01, 9, 9, 9]))
    assert outputs["torque"] == pytest.approx(0.02)
    assert outputs["opening"] == pytest.approx(0.06)


def after_a_step(control, set_point, torque):
    """The pressure when, after a first sample at rest, set point and torque are as given."""
    simulator = Simulator(control)
    context = simulator.get_mutable_context()
    for which, joints in FINGERS.items():
        control.GetInputPort(f"{which}.tip_pose").FixValue(context, [0.0, 0.1, 0.0])
        control.GetInputPort(f"{which}.external_torque").FixValue(context, np.zeros(joints))
    control.GetInputPort("set_point").FixValue(context, [0.09])
    simulator.AdvanceTo(0.005)
    control.GetInputPort("set_point").FixValue(context, [set_point])
    control.GetInputPort("first.external_torque").FixValue(context, [-2 * torque, 0.0, 0.0])
    return control.GetOutputPort("pressure").Eval(context)[0]


def test_the_lower_pressure_is_taken():
    """Both answer in proportion: 1e5 Pa/m to the opening, 1e6 Pa/(N m) to the torque, which begins at no limit."""
    alone, limited = grip_control(), grip_control(torque_limit=0.02)
    assert after_a_step(alone, 0.07, 0.01) == pytest.approx(2e3)
    unwound = MAXIMUM * (1 - 0.01 / PidGains().tracking_time)  # toward the pressure that was applied
    assert after_a_step(limited, 0.07, 0.01) == pytest.approx(unwound - 10e3)
    assert after_a_step(limited, 0.07, -0.01) == pytest.approx(2e3)
    assert after_a_step(limited, 0.11, -0.01) == pytest.approx(-2e3)


TENDONS = "package://soft_gripper/grippers/two_finger_tendons.urdf"
FOLLOWED = ["control.set_points=[0.06, 0.03, 0.05]", "gravity=[0, 0, 0]", "control.hold=6.0"]


def test_tendons_close_the_loop():
    gains = ["tendons.maximum=10", "control.gains={kp: 10.0, ki: 60.0, kd: 0.0}"]
    table = step_table(*run("tip_distance_steps", f"models.gripper.file={TENDONS}", *gains, *FOLLOWED))
    assert max(abs(row.steady_error_estimated_mm) for row in table) < 0.5


@pytest.mark.parametrize(
    ("gains", "shares"),
    [
        ([2.0], [1.0]),
        ([-1.5, 0.75, 0.75], [-1.0, 1.0, 1.0]),
        ([3.0, 1.0, -2.0], [1.0, 1 / 3, -5 / 3]),
        ([-2.0, 0.0], [-1.0, 0.0]),
    ],
)
def test_shares_bend_alike_both_ways_by_the_least_pressures(gains, shares):
    np.testing.assert_allclose(allocation(np.array(gains)), shares)
