"""What drives a finger: its pressure, by whatever law, and what it remembers, if it creeps, of its estimated shapes."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.diagrams.wiring.estimation import FingerEstimation
from soft_gripper.estimators.driving_torque import DrivingTorque, recorded_driving
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS, find_estimator
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import CreepBranch, PressureLaw
from soft_gripper.fingers.kinematics import in_space
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.signals import signal_of

PERIOD, PRESSURE = 0.01, 80e3  # s, Pa
BRANCHES = (CreepBranch(0.2, 0.5), CreepBranch(0.1, 4.0))
UPRIGHT, GRAVITY = np.eye(3, 4).ravel(), np.array([0.0, 0.0, -9.81])
IN_PLANE = -9.81 + 0j


@pytest.fixture
def creeping(shipped_finger):
    return replace(shipped_finger, creep=BRANCHES)


class Sampled:
    """A block or diagram whose samples are given by hand, one a period."""

    def __init__(self, system):
        self.system, self.context, self.samples = system, system.CreateDefaultContext(), 0

    def sample(self, output, **inputs):
        """An output at the next sample."""
        if self.samples:
            self.context.SetTime(self.samples * PERIOD)
            self._update()
        for name, value in inputs.items():
            self.system.GetInputPort(name).FixValue(self.context, value)
        if not self.samples:
            self._update()
        self.samples += 1
        return self.system.GetOutputPort(output).Eval(self.context).copy()

    def _update(self):
        self.context.SetDiscreteState(self.system.EvalUniquePeriodicDiscreteUpdate(self.context))


def memory(finger, angles):
    """What the block adds to the torque of the pressure, sample for sample, N m, (T, N)."""
    block = Sampled(DrivingTorque(finger, PERIOD))
    torques = [block.sample("driving_torque", pressure=[PRESSURE], estimated_joint_angles=q) for q in angles]
    return np.array(torques) - finger.pressure_torque(PRESSURE)


@pytest.mark.parametrize("law", [None, PressureLaw((0.0, 1e5), (0.0, 1.3e5))], ids=["as it is", "by a law"])
def test_without_creep_it_is_the_torque_of_the_pressure(shipped_finger, law):
    finger = replace(shipped_finger, pressure_law=law)
    block = DrivingTorque(finger, PERIOD)
    assert block.num_input_ports() == 1
    context = block.CreateDefaultContext()
    assert context.is_stateless()
    block.GetInputPort("pressure").FixValue(context, [PRESSURE])
    torque = block.get_output_port().Eval(context)
    np.testing.assert_array_equal(torque, finger.pressure_torque(PRESSURE))
    assert torque[0] == pytest.approx(PRESSURE * (1.0 if law is None else 1.3) * finger.pressure_gain[0])
    assert signal_of(block.get_output_port()).unit == "N m"


def test_what_is_not_estimated_leaves_the_memory_as_it_is(creeping, bent):
    """For as long as it lasts, at the joints that it concerns, and no longer."""
    angles = np.tile(bent(12), (200, 1))
    angles[100:150, 6:] = np.nan
    angles[120, 0] = np.inf
    found, whole = memory(creeping, angles), memory(creeping, np.tile(bent(12), (200, 1)))
    assert np.isfinite(found).all()
    np.testing.assert_allclose(found[101:151, 6:], np.tile(whole[100, 6:], (50, 1)), rtol=1e-12)
    np.testing.assert_allclose(found[150:, 6:], whole[100:150, 6:], rtol=1e-12)
    np.testing.assert_allclose(found[:, 1:6], whole[:, 1:6], rtol=1e-12)


def ballooning(finger):
    """The finger, of whose stiffness the pressure leaves a fifth."""
    return replace(finger, pressure_law=PressureLaw((0.0, PRESSURE), (0.0, 0.2 * PRESSURE), (0.0, 0.8)))


def test_before_anything_is_estimated_a_finger_is_taken_to_bend_freely(shipped_finger):
    """An estimate acts from the next sample on, and stays while nothing is estimated."""
    finger = ballooning(shipped_finger)
    block, q, unseen = (
        Sampled(DrivingTorque(finger, PERIOD)),
        free_bending_angles(finger, PRESSURE),
        np.full(12, np.nan),
    )
    torques = [
        block.sample("driving_torque", pressure=[PRESSURE], estimated_joint_angles=angles)
        for angles in (unseen, q / 2, unseen, unseen)
    ]
    seen = finger.pressure_torque(PRESSURE) + 0.8 * finger.stiffness * q / 2
    for found, expected in zip(torques, [finger.stiffness * q] * 2 + [seen] * 2, strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12)


def test_a_recording_remembers_shapes_of_zeroed_sensors_as_the_block_does(creeping):
    """Sensors that read too much are zeroed after 0.7 s in which the gripper is open."""
    layout, uncertainty = SensorLayout(creeping, 4), Uncertainty(free_pressure=2e3)
    pressure = np.repeat([0.0, PRESSURE], [80, 40])
    q = creeping.angle(creeping.pressure_torque(pressure))
    strain = layout.response.reading(extension_ratios(layout, q) + 0.02)
    block = Sampled(
        FingerEstimation(find_estimator("gaussian", uncertainty)(layout, GRAVITY, PERIOD), layout, GRAVITY, PERIOD)
    )
    sampled = [
        block.sample("driving_torque", strain=read, pressure=[p], X_WB=UPRIGHT)
        for read, p in zip(strain, pressure, strict=True)
    ]
    function = SHAPE_FUNCTIONS["gaussian"](layout, uncertainty, PERIOD)
    found = recorded_driving(function, creeping, strain, pressure, in_space(np.array(IN_PLANE)), PERIOD)
    np.testing.assert_allclose(found, sampled, rtol=0, atol=1e-7)
