"""ShapeEstimator: a function of arrays as a block, with a port for everything that the function estimates."""

import numpy as np
import pytest
from loaded_fingers import Push, in_balance
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.estimators.finger_shape import Places, position_std
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.plane import pose_entries, to_base
from soft_gripper.estimators.shape_estimator import POSTERIOR, ShapeEstimator, contact_port
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

GRAVITY, PRESSURE = np.array([0.5, -1.0, -9.0]), 80e3  # m/s^2, Pa
X_WB = RigidTransform(RollPitchYaw(2.0, 0.3, -0.4), [0.1, 0.2, 0.3])
IN_BASE = to_base(pose_entries(X_WB), GRAVITY)
PORTS = {"arcs": 1, "spline": 1, "gaussian": 4, "contact": 23}  # how many of these


@pytest.fixture(params=PORTS)
def kind(request):
    return request.param


@pytest.fixture
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 3, borders=(0.25, 0.6))


@pytest.fixture
def driving(layout):
    return layout.finger.pressure_torque(PRESSURE)


@pytest.fixture
def strain(layout):
    q = in_balance(layout.finger, PRESSURE, complex(IN_BASE[2], IN_BASE[0]), [Push(0.09, 0.8)])
    return layout.response.reading(extension_ratios(layout, q))


def block_of(kind, layout):
    return ShapeEstimator(SHAPE_FUNCTIONS[kind](layout, Uncertainty()), layout, GRAVITY)


def fixed(block, strain, driving):
    context = block.CreateDefaultContext()
    for name, value in (("strain", strain), ("driving_torque", driving), ("X_WB", pose_entries(X_WB))):
        block.GetInputPort(name).FixValue(context, value)
    return context


def of_no_curve(block):
    """Its ports but for those of arcs and places, which have tests of their own."""
    curve = ("theta", "kappa", "arcs", "joint_positions", "tip_pose", "joint_positions_world")
    curve += ("estimated_joint_positions", "estimated_tip_position")
    return {name: port for name, port in vector_outputs(block).items() if name not in curve}


def test_ports_have_what_the_function_gives(kind, layout, strain, driving):
    block = block_of(kind, layout)
    context = fixed(block, strain, driving)
    found = {name: port.Eval(context) for name, port in of_no_curve(block).items()}
    function = SHAPE_FUNCTIONS[kind](layout, Uncertainty())
    shape = function(strain, driving, IN_BASE)
    expected = {"estimated_joint_angles": shape.q}
    if shape.covariance is not None:
        expected["joint_angle_covariance"] = shape.covariance.ravel()
        expected["position_std"] = position_std(layout.finger, shape.q, shape.covariance)
        variance = Places(layout.finger, ["bending"]).variance(shape.q, shape.covariance)
        expected["tip_position_std"] = np.sqrt(variance[-1])
    if shape.contact is not None:
        expected |= {contact_port(name): np.ravel(value) for name, value in shape.contact._asdict().items()}
        expected["contact_force_world"] = X_WB.rotation() @ shape.contact.vector
        posterior = function.posterior(strain, driving, IN_BASE)
        expected |= {contact_port(name): np.atleast_1d(getattr(posterior, name)) for name in POSTERIOR}
        assert found["contact_force"] == pytest.approx(0.8, rel=0.01)
        assert found["contact_force_set"][0] < 0.8 < found["contact_force_bounds"][0]
    assert found.keys() == expected.keys()
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], value, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("lost", [[0], [1, 4], list(range(6))])
def test_what_is_not_read_lasts_no_longer_than_it_is_not(kind, layout, strain, driving, lost):
    """The arcs have no shape then; the others do without."""
    block = block_of(kind, layout)
    angles = block.GetOutputPort("estimated_joint_angles")
    context = fixed(block, strain, driving)
    before = angles.Eval(context).copy()
    spoiled = strain.copy()
    spoiled[lost] = np.nan
    block.GetInputPort("strain").FixValue(context, spoiled)
    assert np.isfinite(angles.Eval(context)).all() == (kind != "arcs")
    block.GetInputPort("strain").FixValue(context, strain)
    np.testing.assert_array_equal(angles.Eval(context), before)


def test_the_base_turns_gravity(layout, strain, driving):
    block = block_of("gaussian", layout)
    context = fixed(block, strain, driving)
    angles = block.GetOutputPort("estimated_joint_angles")
    askew = angles.Eval(context).copy()
    block.GetInputPort("X_WB").FixValue(context, pose_entries(RigidTransform()))
    upright = SHAPE_FUNCTIONS["gaussian"](layout, Uncertainty())(strain, driving, np.array([0.5, -1.0, -9.0])).q
    np.testing.assert_allclose(angles.Eval(context), upright, atol=1e-15)
    assert np.abs(askew - upright).max() > 1e-6
