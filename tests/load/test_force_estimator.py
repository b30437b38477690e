"""ForceEstimator: the balance of torques behind ports, sample for sample, and silence where nothing is touched."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.estimators.plane import pose_entries
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.load.force_estimator import ForceEstimator
from soft_gripper.models import DIRECTORY

GRAVITY = np.array([0.0, 0.0, -9.81])
PERIOD = 0.01  # s
PRESSURE = 80e3  # Pa
POSES = [
    RigidTransform(RollPitchYaw(angles), [0.3, -0.2, 0.5])
    for angles in ([0, 0, 0], [np.pi, 0, 0], [0, np.pi / 2, 0], [0.4, -1.1, 2.5])
]


class Estimator:
    """A ForceEstimator whose samples are given by hand, one a period."""

    def __init__(self, finger, gravity=GRAVITY, block=None):
        self.block = block or ForceEstimator(finger, gravity, PERIOD)
        self.context = self.block.CreateDefaultContext()
        self.samples = 0

    def sample(self, q, driving=0.0, X_WB=POSES[3]):
        """Free bending angles, external torque and tolerance at the next sample."""
        self.context.SetTime(self.samples * PERIOD)
        self.context.SetDiscreteState(self.block.EvalUniquePeriodicDiscreteUpdate(self.context))
        self.samples += 1
        driving = np.broadcast_to(driving, np.shape(q))
        values = {"estimated_joint_angles": q, "driving_torque": driving, "X_WB": pose_entries(X_WB)}
        for name, value in values.items():
            self.block.GetInputPort(name).FixValue(self.context, value)
        return [self.block.get_output_port(i).Eval(self.context) for i in range(3)]

    def rest(self, *sample):
        """The same at the last of five samples that are alike."""
        return [self.sample(*sample) for _ in range(5)][-1]


@pytest.fixture
def balanced_finger(shipped_finger):
    """Joint angles at which pressure and weight of a finger on a base at X_WB balance, and that weight, by Drake."""

    def balance(X_WB):
        plant = MultibodyPlant(0.0)
        Parser(plant).AddModelsFromString(expand_urdf(DIRECTORY / "grippers" / "finger.urdf").text, "urdf")
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("mount"), X_WB)
        plant.Finalize()
        context = plant.CreateDefaultContext()
        q = weight = np.zeros(12)
        for _ in range(100):
            q = (PRESSURE * shipped_finger.pressure_gain + weight) / shipped_finger.stiffness
            plant.SetPositions(context, q)
            weight = plant.CalcGravityGeneralizedForces(context)
        return q, weight

    return balance


@pytest.mark.parametrize("X_WB", POSES, ids=["upright", "hanging", "horizontal", "askew"])
def test_compensation_takes_out_the_weight_and_nothing_else(shipped_finger, balanced_finger, X_WB):
    q, weight = balanced_finger(X_WB)
    driving = shipped_finger.pressure_torque(PRESSURE)
    _, compensated, _ = Estimator(shipped_finger).rest(q, driving, X_WB)
    _, without, _ = Estimator(shipped_finger, np.zeros(3)).rest(q, driving, X_WB)
    np.testing.assert_allclose(compensated, 0, atol=1e-12)
    np.testing.assert_allclose(without, weight, atol=1e-12)
    assert np.abs(weight).max() > 2e-3


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_bad_sample_lasts_no_longer_than_five(shipped_finger, bent, bad):
    estimator, q = Estimator(shipped_finger), 0.1 * bent(12)
    before, lost = estimator.rest(q), q.copy()
    lost[-1] = bad
    with np.errstate(invalid="ignore"):
        after = [estimator.sample(lost), *(estimator.sample(q) for _ in range(5))]
    for free, torque, tolerance in after[:5]:
        np.testing.assert_array_equal(free, before[0])
        assert not np.isfinite([torque, tolerance]).any()
    np.testing.assert_array_equal(after[5], before)


def test_torque_belongs_to_two_samples_ago(shipped_finger):
    """A finger that is bent slowly has the torque of where it was."""
    finger = replace(shipped_finger, relaxation_time=0.0)
    estimator, ramp = Estimator(finger, np.zeros(3)), 1e-4 * np.arange(12)[:, None] * np.ones(12)
    torques = [estimator.sample(q)[1] for q in ramp]
    np.testing.assert_allclose(torques[4:], finger.stiffness * ramp[2:-2], atol=1e-7)


def test_noisy_shapes_are_not_differentiated(shipped_finger):
    """Of noise in the joint angles what is left is that of the elastic torque; the rest is as without noise."""
    rng = np.random.default_rng(2)
    noise = 2e-3 * rng.standard_normal((40, shipped_finger.segments))
    still = free_bending_angles(shipped_finger, np.array(PRESSURE))
    torques = {}
    for noisy in (False, True):
        estimator = Estimator(None, block=ForceEstimator(shipped_finger, np.zeros(3), PERIOD, noisy))
        torques[noisy] = np.array([estimator.sample(still + each)[1] for each in noise])[5:, 0]
    assert torques[False].std() > 3 * torques[True].std()
    assert torques[True].std() < 1.5 * 2e-3 * shipped_finger.stiffness[0]


def test_a_finger_moves_as_it_is_driven(shipped_finger):
    """Free bending under a slowly changing pressure: the same with and without differences of its shape."""
    pressures = PRESSURE + 2e3 * np.sin(2 * np.pi * np.arange(60) * PERIOD)
    found = {}
    for noisy in (False, True):
        estimator = Estimator(None, block=ForceEstimator(shipped_finger, np.zeros(3), PERIOD, noisy))
        shapes = free_bending_angles(shipped_finger, pressures)
        driving = shipped_finger.pressure_torque(pressures)
        found[noisy] = [estimator.sample(*sample)[1] for sample in zip(shapes, driving, strict=True)]
    np.testing.assert_allclose(found[True][5:], found[False][5:], atol=1e-9)
    assert np.abs(found[False][5:]).max() > 1e-5
