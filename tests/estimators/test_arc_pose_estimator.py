"""ArcPoseEstimator: the pure functions, sample for sample."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.errors import InputError
from soft_gripper.estimators.arc_pose_estimator import ArcPoseEstimator
from soft_gripper.estimators.arc_shapes import BendSharing
from soft_gripper.estimators.arcs import arcs_from_readings, joints_on_arcs
from soft_gripper.estimators.plane import pose_entries
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.link_sensors import CurvatureSensors
from soft_gripper.sensors.sensor_layout import extension_ratios

X_WB = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.1, -0.2, 0.3])
GRAVITY = np.array([0.0, 0.0, -9.81])
DRIVING = np.linspace(0.05, 0.02, 12)  # N m


class Fixed:
    """An estimator whose inputs are fixed by hand."""

    def __init__(self, layout):
        self.system = ArcPoseEstimator(layout, GRAVITY)
        self.context = self.system.CreateDefaultContext()
        self.fix(driving_torque=DRIVING, X_WB=pose_entries(X_WB))

    def fix(self, **values):
        for port, value in values.items():
            self.system.GetInputPort(port).FixValue(self.context, value)

    def read(self, strain):
        """All outputs for a reading, {port: value}."""
        self.fix(strain=strain)
        ports = [self.system.get_output_port(i) for i in range(self.system.num_output_ports())]
        return {port.get_name(): port.Eval(self.context) for port in ports}


def expected(layout, strain):
    """What the ports hold, by the pure functions; strain (..., readings)."""
    arcs = arcs_from_readings(layout, strain)
    joints, leading = joints_on_arcs(layout, arcs), strain.shape[:-1]
    frame = X_WB.rotation().matrix()
    x, _, z = X_WB.rotation().inverse() @ GRAVITY
    angles = BendSharing(layout).joint_angles(arcs.theta, np.broadcast_to(DRIVING, (*leading, 12)), complex(z, x))
    xyz = as_points(joints)[..., :1] * frame[:, 0] + as_points(joints)[..., 1:] * frame[:, 2]
    columns = (
        as_points(arcs.start),
        np.stack([arcs.heading, arcs.kappa, arcs.length], axis=-1),
        as_points(arcs.centers),
    )
    return {
        "estimated_joint_angles": angles,
        "theta": arcs.theta,
        "kappa": arcs.kappa,
        "arcs": np.concatenate(columns, axis=-1).reshape(*leading, -1),
        "joint_positions": as_points(joints).reshape(*leading, -1),
        "tip_pose": np.concatenate([as_points(arcs.end[..., -1]), arcs.tip_heading[..., None]], axis=-1),
        "joint_positions_world": (xyz + X_WB.translation()).reshape(*leading, -1),
    }


def assert_same(outputs, wanted):
    assert set(outputs) == set(wanted)
    for port, value in wanted.items():
        np.testing.assert_allclose(outputs[port], value, atol=1e-15, err_msg=port)


@pytest.fixture
def strain(layout, bent):
    return layout.response.reading(extension_ratios(layout, bent(12)))


def test_block_is_the_pure_functions(layout, strain):
    assert_same(Fixed(layout).read(strain), expected(layout, strain))


@pytest.mark.parametrize("change", [{"driving_torque": -DRIVING}, {"X_WB": pose_entries(RigidTransform())}], ids=list)
def test_joint_angles_follow_drive_and_weight(layout, strain, change):
    """The bend of the sections stays as it is measured; only its shares change."""
    estimator = Fixed(layout)
    before = estimator.read(strain)
    estimator.fix(**change)
    after = estimator.read(strain)
    angles, others = (signals.pop("estimated_joint_angles") for signals in (before, after))
    assert np.abs(angles - others).max() > 1e-5
    for shared in (angles, others):
        np.testing.assert_allclose(np.add.reduceat(shared, layout.section_ends[:-1]), before["theta"], atol=1e-14)
    world = {"joint_positions_world"} if "X_WB" in change else set()
    np.testing.assert_equal(*({k: v for k, v in signals.items() if k not in world} for signals in (before, after)))


def test_sensors_of_curvature_are_refused(shipped_finger):
    with pytest.raises(InputError, match=r"ArcPoseEstimator: sensor\.type = 'curvature': works with strain sensors"):
        ArcPoseEstimator(CurvatureSensors(shipped_finger, 2), GRAVITY)
