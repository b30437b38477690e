"""Tendons: springs that do not push, and the capstan equation along a bent finger; and which actuators they drive."""

from dataclasses import replace

import numpy as np
import pytest
from finger_plants import uniform_finger
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.loaded_model import add_fingers
from soft_gripper.fingers.path_drive import TendonDrive, Tendons
from soft_gripper.fingers.paths import Tendon
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


def test_tension_turns_each_joint_by_its_lever():
    torque = Tendons(plain()).torques(bent(0.5), np.array([5.0]))
    np.testing.assert_allclose(torque["bending"], 5.0 * LEVER)
    np.testing.assert_allclose(torque["sideways"], 0.0, atol=1e-15)


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
