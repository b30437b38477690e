"""Drives of tendons and pressures."""

from dataclasses import replace

import numpy as np
import pytest
from finger_plants import built_at, uniform_finger
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from soft_gripper.diagrams.loaded_model import add_fingers
from soft_gripper.fingers.finger_parts import YIELDS, PressureLaw
from soft_gripper.fingers.path_drive import TendonDrive, Tendons
from soft_gripper.fingers.paths import Tendon
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.pressure_drive import PressureDrive, pressure_torque_map
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY

LEVER = 8e-3  # m, from the neutral axis to the tendon


def plain(friction=0.0, stiffness=0.0, y=0.0):
    """A finger whose only tendon runs inside of the neutral axis."""
    finger = uniform_finger(12)
    tendon = Tendon("t", (finger.base.neutral_axis + LEVER,), (y,), (0.0, 1.0), stiffness, friction)
    return replace(finger, yields=("bending", "sideways", "twist"), tendons=(tendon,))


def bent(angle, sideways=0.0, segments=12):
    ways = {"bending": angle, "sideways": sideways, "twist": 0.0}
    return {way: np.full(segments, total / segments) for way, total in ways.items()}


@pytest.mark.parametrize(("angle", "sideways", "total"), [(2.0, 0.0, 2.0), (1.2, 1.6, 2.0), (-2.0, 0.0, 2.0)])
def test_friction_decays_over_the_angle_of_the_bend(angle, sideways, total):
    """The capstan equation: what arrives at the far end is exp(-mu phi) of the tension, or exp(mu phi) if let go."""
    sheath, q = Tendons(plain(friction=0.3)), bent(angle, sideways)
    passed = total * (np.arange(12) + 0.5) / 12
    smooth = sheath.torques(q, np.array([5.0]))["bending"]
    for sliding in (1.0, 0.0, -1.0):
        torque = sheath.torques(q, np.array([5.0]), np.array([sliding]))["bending"]
        np.testing.assert_allclose(torque, smooth * np.exp(-0.3 * sliding * passed))


def test_friction_turns_over_a_short_travel():
    sheath, z = Tendons(plain(friction=0.3)), np.array([-1.0])
    np.testing.assert_allclose(sheath.next_sliding(z, np.array([0.0])), z)
    np.testing.assert_allclose(sheath.next_sliding(z, np.array([2e-4])), 1 - 2 / np.e)
    twice = sheath.next_sliding(sheath.next_sliding(z, np.array([1e-4])), np.array([1e-4]))
    np.testing.assert_allclose(twice, 1 - 2 / np.e, rtol=1e-12)
    np.testing.assert_allclose(sheath.next_sliding(z, np.array([1.0])), 1.0)


def test_a_pulled_tendon_is_a_spring_that_does_not_push():
    winch, q = Tendons(plain(stiffness=2e3)), bent(0.5)
    shortened = LEVER * 0.5
    np.testing.assert_allclose(winch.tensions(q, np.array([shortened + 1e-3])), 2.0)
    np.testing.assert_allclose(winch.tensions(q, np.array([shortened - 1e-3])), 0.0)


def test_the_drive_of_a_finger_reaches_its_own_joints_alone(tmp_path):
    """Two fingers of one model yield in three ways each: their joints are some of those that the model actuates."""
    plant = MultibodyPlant(0.01)
    text = (DIRECTORY / "grippers/two_finger_tendons.urdf").read_text()
    in_space = tmp_path / "in_space.urdf"
    text = text.replace('relaxation_time="0.02"', 'relaxation_time="0.02" yields="bending sideways twist"')
    in_space.write_text(text.replace('x="8e-3" y="0"', 'x="8e-3 4e-3" y="0 6e-3"'))
    fingers = add_fingers(Parser(plant), in_space)
    plant.Finalize()
    for finger in fingers:
        drive = TendonDrive(finger, "tension")
        context, state = drive.CreateDefaultContext(), np.zeros(plant.num_multibody_states())
        q = {way: 0.02 + 0.01 * np.arange(len(finger.joints)) for way in finger.finger.yields}
        for way, angles in q.items():
            state[[joint.position_start() for joint in finger.joints_of(way)]] = angles
        drive.GetInputPort("state").FixValue(context, state)
        drive.GetInputPort("tension_command").FixValue(context, [2.0])
        actuation = dict(zip(finger.actuator_names, drive.GetOutputPort("actuation").Eval(context), strict=True))
        for way, torques in Tendons(finger.finger).torques(q, np.array([2.0])).items():
            own = [actuation.pop(joint.name()) for joint in finger.joints_of(way)]
            np.testing.assert_allclose(own, torques)
            assert np.abs(torques).min() > 1e-6
        assert set(actuation.values()) <= {0.0}, "the other finger is driven by its own"


@pytest.mark.parametrize("hostile", [np.nan, np.inf, 1e308])
def test_a_state_that_is_not_finite_leaves_nothing_in_the_friction(hostile):
    """Of two environments one is hit: it goes on from where it was, and the other does not notice."""
    plant = MultibodyPlant(0.01)
    finger, _ = add_fingers(Parser(plant), DIRECTORY / "grippers/two_finger_tendons.urdf")
    plant.Finalize()
    drive, states = TendonDrive(finger, "tension"), np.zeros((6, 2, plant.num_multibody_states()))
    bent = [joint.position_start() for joint in finger.joints_of("bending")]
    states[..., bent] = 0.01 * np.arange(6)[:, None, None]
    before = expected = drive.initial_friction(states[0])
    states[2, 1, bent] = hostile
    with np.errstate(all="ignore"):
        for number in range(1, 6):
            before = drive.next_friction(before, states[number])
            expected = drive.next_friction(expected, np.tile(states[number, :1], (2, 1)))
    np.testing.assert_array_equal(before[0], expected[0])
    np.testing.assert_allclose(before[1], expected[1], atol=0.05)
    assert np.isfinite(drive.actuation(states[-1], np.full((2, 1), 2.0), before)).all()


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
