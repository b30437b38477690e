"""PressureDrive: limits, lag and the chamber law, from Drake's own blocks."""

from dataclasses import replace

import numpy as np
import pytest
from finger_plants import built_at
from pydrake.systems.analysis import Simulator

from soft_gripper.fingers.finger_parts import YIELDS, PressureLaw
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.pressure_drive import PressureDrive, pressure_torque_map
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY

MAPS = {
    "left": np.array([1.0, 2.0, 0.0, 0.0]) * 1e-6,
    "right": np.array([0.0, 0.0, 3.0, 4.0]) * 1e-6,
}  # N m/Pa
LIMITS = (-60e3, 250e3)  # Pa
LAG = 0.05  # s


def evaluate(drive, left, right):
    """Pressures in the chambers and actuation for two fixed commands, without lag."""
    context = drive.CreateDefaultContext()
    for finger, pressure in (("left", left), ("right", right)):
        drive.GetInputPort(f"{finger}.pressure_command").FixValue(context, [pressure])
    pressures = [drive.GetOutputPort(f"{finger}.pressure").Eval(context)[0] for finger in ("left", "right")]
    return pressures, drive.GetOutputPort("actuation").Eval(context)


@pytest.mark.parametrize(("command", "pressure"), [(300e3, 250e3), (-100e3, -60e3), (250e3, 250e3), (7.0, 7.0)])
def test_pressure_keeps_within_the_limits(command, pressure):
    pressures, actuation = evaluate(PressureDrive(MAPS, *LIMITS), command, 0.0)
    assert pressures == [pressure, 0.0]
    np.testing.assert_allclose(actuation, MAPS["left"] * pressure, rtol=1e-12)


@pytest.mark.parametrize("time_step", [0.0, 0.1 * LAG, 0.5 * LAG])  # s; in steps it is exact, however long they are
@pytest.mark.parametrize("time", [0.5 * LAG, LAG, 3 * LAG])
def test_pressure_follows_the_limited_command_as_a_first_order_lag(time, time_step):
    drive = PressureDrive(MAPS, *LIMITS, LAG, time_step)
    simulator = Simulator(drive)
    simulator.get_mutable_integrator().set_target_accuracy(1e-6)
    context = simulator.get_mutable_context()
    for finger, command in (("left", 1e6), ("right", 100e3)):
        drive.GetInputPort(f"{finger}.pressure_command").FixValue(context, [command])
    simulator.AdvanceTo(time)
    risen = 1 - np.exp(-time / LAG)  # 63 % after the time constant
    assert drive.GetOutputPort("left.pressure").Eval(context)[0] == pytest.approx(250e3 * risen, rel=1e-4)
    assert drive.GetOutputPort("right.pressure").Eval(context)[0] == pytest.approx(100e3 * risen, rel=1e-4)
    expected = 250e3 * risen * MAPS["left"] + 100e3 * risen * MAPS["right"]
    np.testing.assert_allclose(drive.GetOutputPort("actuation").Eval(context), expected, rtol=1e-4)


def test_chamber_law_acts_on_the_joints_of_its_finger_alone(load_plant):
    expanded = expand_urdf(DIRECTORY / "grippers/two_finger.urdf")
    plant = load_plant(expanded.text, "palm")
    model = plant.GetModelInstanceByName("two_finger")
    for finger in expanded.fingers:
        of_plant = PlantFinger(finger, plant, model)
        torque = plant.MakeActuationMatrix() @ pressure_torque_map(of_plant)[:, 0]
        joints = [plant.GetJointByName(f"{finger.name}_joint_{i}").velocity_start() for i in range(12)]
        sections = [built_at(finger, (i + 0.5) * 0.01) for i in range(12)]
        law = [section.chamber_area * section.chamber_eccentricity for section in sections]
        np.testing.assert_allclose(torque[joints], law, rtol=1e-12)
        assert np.count_nonzero(torque) == 12


@pytest.mark.parametrize("pressure", [-20e3, 0.0, 15e3, 60e3, 200e3])
def test_every_pressure_has_its_own_law(pressure):
    """Laws of other points, side by side: beyond their ends both are straight."""
    laws = {"left": [PressureLaw((-1e4, 0.0, 1e5), (-3e4, 0.0, 2e5))], "right": [PressureLaw((0.0, 2e4), (0.0, 1e4))]}
    drive = PressureDrive(MAPS, *LIMITS, laws=laws)
    pressures, actuation = evaluate(drive, pressure, pressure)
    left, right = pressure * (3 if pressure < 0 else 2), pressure / 2
    assert pressures == [pressure, pressure]
    np.testing.assert_allclose(actuation, left * MAPS["left"] + right * MAPS["right"], atol=1e-15)


def test_a_finger_that_stretches_is_pushed_along_too(shipped_finger, finger_plant):
    finger = replace(shipped_finger, yields=YIELDS)
    plant = finger_plant(finger)
    of_plant = PlantFinger(finger, plant, plant.GetModelInstanceByName("robot"))
    torques = pressure_torque_map(of_plant)[:, 0]
    areas = [built_at(finger, s).chamber_area for s in finger.joint_arc_lengths]
    np.testing.assert_allclose(of_plant.actuator_selector("stretch") @ torques, areas, rtol=1e-12)
    np.testing.assert_array_equal(of_plant.actuator_selector() @ torques, finger.pressure_gain)
    assert len(torques) == 2 * 12
