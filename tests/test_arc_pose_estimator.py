"""ArcPoseEstimator: the pure functions as a block, sample for sample."""

from unittest.mock import Mock

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantValueSource,
    LogVectorOutput,
    MatrixGain,
    TrajectorySource,
)
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arc_pose_estimator import ArcPoseEstimator, bending_plane, to_world
from soft_gripper.kinematics import as_points
from soft_gripper.sensor_layout import arcs_from_readings, extension_ratios, joints_on_arcs
from soft_gripper.strain_sensor import StrainSensor

X_WB = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.1, -0.2, 0.3])


class Fixed:
    """An estimator whose inputs are fixed by hand."""

    def __init__(self, layout):
        self.system = ArcPoseEstimator(layout)
        self.context = self.system.CreateDefaultContext()
        self.system.GetInputPort("X_WB").FixValue(self.context, X_WB)

    def read(self, strain):
        """All outputs for a reading, {port: value}."""
        self.system.GetInputPort("strain").FixValue(self.context, strain)
        ports = [self.system.get_output_port(i) for i in range(self.system.num_output_ports())]
        return {port.get_name(): port.Eval(self.context) for port in ports}


def expected(layout, strain):
    """What the ports hold, by the pure functions; strain (..., readings)."""
    arcs = arcs_from_readings(layout, strain)
    joints, leading = joints_on_arcs(layout, arcs), strain.shape[:-1]
    frame = X_WB.rotation().matrix()
    xyz = as_points(joints)[..., :1] * frame[:, 0] + as_points(joints)[..., 1:] * frame[:, 2]
    columns = (
        as_points(arcs.start),
        np.stack([arcs.heading, arcs.kappa, arcs.length], axis=-1),
        as_points(arcs.centers),
    )
    return {
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


def test_world_positions_are_those_of_drakes_transform(layout, strain):
    outputs = Fixed(layout).read(strain)
    for (x, z), world in zip(
        outputs["joint_positions"].reshape(-1, 2),
        outputs["joint_positions_world"].reshape(-1, 3),
        strict=True,
    ):
        np.testing.assert_allclose(world, X_WB.multiply([x, 0.0, z]), atol=1e-15)


def test_world_positions_of_a_batch(bent):
    joints = bent(2, 3) + 1j * bent(2, 3)
    single = [[to_world(joint, bending_plane(X_WB)) for joint in row] for row in joints]
    np.testing.assert_allclose(to_world(joints, bending_plane(X_WB)), single, atol=1e-15)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_bad_sample_spoils_the_pose_from_its_section_on_and_only_while_it_lasts(layout, strain, bad):
    estimator, last = Fixed(layout), layout.sections - 1
    good = estimator.read(strain)
    for section in range(layout.sections):
        spoiled = strain.copy()
        spoiled[section] = bad
        outputs = estimator.read(spoiled)
        np.testing.assert_array_equal(np.isnan(outputs["theta"]), np.arange(last + 1) == section)
        joints = outputs["joint_positions"].reshape(-1, 2)
        before = layout.joint_sections < section
        np.testing.assert_array_equal(joints[before], good["joint_positions"].reshape(-1, 2)[before])
        assert np.isnan(joints[~before]).all()
        world = outputs["joint_positions_world"].reshape(-1, 3)
        np.testing.assert_array_equal(np.isnan(world).any(axis=1), ~before)
        assert np.isnan(outputs["tip_pose"]).all()
        np.testing.assert_equal(estimator.read(strain), good)


def test_a_moved_base_moves_the_world_positions_alone(layout, strain):
    estimator = Fixed(layout)
    before = estimator.read(strain)
    estimator.system.GetInputPort("X_WB").FixValue(estimator.context, RigidTransform([1.0, 2.0, 3.0]) @ X_WB)
    after = estimator.read(strain)
    shift = (after.pop("joint_positions_world") - before.pop("joint_positions_world")).reshape(-1, 3)
    np.testing.assert_allclose(shift, np.tile([1.0, 2.0, 3.0], (12, 1)), atol=1e-14)
    np.testing.assert_equal(after, before)


def test_each_sample_is_estimated_once_for_all_ports(layout, strain, monkeypatch):
    estimate = Mock(wraps=arcs_from_readings)
    monkeypatch.setattr("soft_gripper.arc_pose_estimator.arcs_from_readings", estimate)
    Fixed(layout).read(strain)
    assert estimate.call_count == 1


def test_ports_and_no_state(layout):
    system = ArcPoseEstimator(layout)
    assert system.GetInputPort("strain").size() == layout.paths * layout.sections
    assert isinstance(system.GetInputPort("X_WB").Allocate().get_value(), RigidTransform)
    assert system.CreateDefaultContext().is_stateless()


@pytest.fixture
def wired(layout):
    """A builder that holds StrainSensor -> ArcPoseEstimator."""
    builder = DiagramBuilder()
    sensor = builder.AddSystem(StrainSensor(layout, 0.01))
    estimator = builder.AddSystem(ArcPoseEstimator(layout))
    base = builder.AddSystem(ConstantValueSource(Value(X_WB)))
    builder.Connect(sensor.GetOutputPort("strain"), estimator.GetInputPort("strain"))
    builder.Connect(base.get_output_port(), estimator.GetInputPort("X_WB"))
    return builder, sensor, estimator


def test_pose_may_act_back_on_the_joints(wired, layout):
    """The sensor holds its sample: a loop around both blocks is no algebraic loop."""
    builder, sensor, estimator = wired
    share = np.eye(layout.sections)[layout.joint_sections] / 24
    back = builder.AddSystem(MatrixGain(share))
    builder.Connect(estimator.GetOutputPort("theta"), back.get_input_port())
    builder.Connect(back.get_output_port(), sensor.GetInputPort("joint_angles"))
    Simulator(builder.Build()).AdvanceTo(0.05)


def test_recording_of_the_blocks_is_the_batch(wired, layout, bent):
    builder, sensor, estimator = wired
    motion = PiecewisePolynomial.FirstOrderHold([0.0, 0.1, 0.2, 0.3], bent(12, 4))
    source = builder.AddSystem(TrajectorySource(motion))
    builder.Connect(source.get_output_port(), sensor.GetInputPort("joint_angles"))
    ports = [estimator.get_output_port(i) for i in range(estimator.num_output_ports())]
    ports.append(sensor.GetOutputPort("sampled_joint_angles"))
    logs = {port.get_name(): LogVectorOutput(port, builder, 0.01) for port in ports}
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.3)
    recorded = {name: log.FindLog(simulator.get_context()).data().T for name, log in logs.items()}
    q = recorded.pop("sampled_joint_angles")
    assert len(np.unique(q[:, 0])) >= 30
    assert_same(recorded, expected(layout, layout.response.reading(extension_ratios(layout, q))))
