"""ForceEstimator: the maths of `external_torque` behind ports, and silence where nothing is touched."""

import numpy as np
import pytest
from finger_plants import free_bending
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.external_torque import external_torque, free_bending_angles, gravity_torque
from soft_gripper.force_estimator import ForceEstimator
from soft_gripper.models import DIRECTORY
from soft_gripper.sensor_layout import SensorLayout
from soft_gripper.urdf import expand_urdf

GRAVITY = np.array([0.0, 0.0, -9.81])
PRESSURE = 80e3  # Pa
FINGERS = ("left_finger", "right_finger")
POSES = [
    RigidTransform(RollPitchYaw(angles), [0.3, -0.2, 0.5])
    for angles in ([0, 0, 0], [np.pi, 0, 0], [0, np.pi / 2, 0], [0.4, -1.1, 2.5])
]
# Where left and right finger stand, too far apart to meet, and how they are turned (roll, pitch, yaw in degrees).
ORIENTATIONS = {
    "hanging": ([180, 0, 0], [180, 0, 180]),
    "upright": ([0, 0, 0], [0, 0, 180]),
    "horizontal": ([0, 90, 0], [0, -90, 0]),  # one closes downward, one upward
}


class Estimator:
    """A ForceEstimator whose inputs are given by hand."""

    def __init__(self, layout, gravity=GRAVITY):
        self.block = ForceEstimator(layout, gravity)
        self.context = self.block.CreateDefaultContext()

    def feel(self, theta, pressure=PRESSURE, X_WB=POSES[3]):
        """Free bending angles and external torque."""
        for name, value in (("theta", theta), ("pressure", [pressure]), ("X_WB", Value(X_WB))):
            self.block.GetInputPort(name).FixValue(self.context, value)
        return [
            self.block.GetOutputPort(name).Eval(self.context) for name in ("free_bending_angles", "external_torque")
        ]


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


def test_ports_are_the_pure_functions(layout, bent):
    finger, estimator = layout.finger, Estimator(layout)
    for theta, pressure in zip(bent(10, layout.sections), 1e5 * bent(10), strict=True):
        for X_WB in POSES:
            x, _, z = X_WB.rotation().inverse() @ GRAVITY
            free, torque = estimator.feel(theta, pressure, X_WB)
            np.testing.assert_array_equal(free, free_bending_angles(finger, np.array(pressure)))
            expected = external_torque(layout, theta, np.array(pressure), complex(z, x))
            np.testing.assert_allclose(torque, expected, rtol=1e-12, atol=1e-16)


@pytest.mark.parametrize("X_WB", POSES, ids=["upright", "hanging", "horizontal", "askew"])
def test_compensation_takes_out_the_weight_and_nothing_else(shipped_finger, balanced_finger, X_WB):
    layout = SensorLayout(shipped_finger, 12)
    q, weight = balanced_finger(X_WB)
    _, compensated = Estimator(layout).feel(q, PRESSURE, X_WB)
    _, without = Estimator(layout, np.zeros(3)).feel(q, PRESSURE, X_WB)
    np.testing.assert_allclose(compensated, 0, atol=1e-12)
    np.testing.assert_allclose(without, weight, atol=1e-12)
    assert np.abs(weight).max() > 5e-3


def test_feels_nothing_while_a_section_is_lost_and_no_longer(layout, bent):
    estimator, theta = Estimator(layout), bent(layout.sections)
    free, torque = estimator.feel(theta)
    lost = theta.copy()
    lost[-1] = np.nan
    still_free, nothing = estimator.feel(lost)
    assert np.isnan(nothing).all()
    np.testing.assert_array_equal(still_free, free)
    np.testing.assert_array_equal(estimator.feel(theta)[1], torque)


def test_has_no_state(layout):
    assert ForceEstimator(layout, GRAVITY).CreateDefaultContext().is_stateless()


def station_feels(signals, pressures, orientation, *overrides):
    """Signals of both fingers at the ends of pressures of 1 s each, (fingers, pressures, N), fingers turned."""
    poses = zip((-0.3, 0.3), ORIENTATIONS[orientation], strict=True)
    turned = [
        f"models.{i}.X_PC={{translation: [{x}, 0, 0.2], rotation: !Rpy {{deg: {deg}}}}}"
        for i, (x, deg) in enumerate(poses)
    ]
    recording = simulate(free_bending(pressures, 1.0, *turned, *overrides))
    ends = 1.0 + np.arange(len(pressures))
    return [
        np.array([recording[f"{finger}.{signal}"].sel(time=ends, method="nearest") for finger in FINGERS])
        for signal in signals
    ]


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_feels_nothing_where_nothing_is_touched(orientation):
    signals = ("external_torque", "true_external_torque")
    felt, truth = station_feels(signals, [-60e3, 30e3, 120e3, 240e3], orientation)
    assert np.abs(truth).max() == 0
    assert np.abs(felt).max() < 2e-3


def test_without_compensation_the_weight_is_felt(shipped_finger):
    signals = ("external_torque", "sampled_joint_angles")
    felt, q = station_feels(signals, [0.0], "horizontal", "sensor.compensate_gravity=false")
    for finger, down in enumerate((9.81, -9.81)):  # along x of the finger
        weight = gravity_torque(shipped_finger, q[finger], 1j * down)
        assert np.abs(weight[:, 0]) > 0.02
        np.testing.assert_allclose(felt[finger], weight, atol=2e-3)
