"""Shape functions and their block: samples, batches, points, and the examples of their docstrings."""

import doctest
import tracemalloc
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest
from loaded_fingers import Push, in_balance, vector
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.estimators.batches import _BATCH_SIZE
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.finger_shape import Places, position_std
from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.plane import pose_entries, to_base
from soft_gripper.estimators.shape_estimator import POSTERIOR, ShapeEstimator, contact_port
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

SOFTENING = ElasticLaw((-30.0, -8.0, 8.0, 30.0), (-0.23, -0.1, 0.1, 0.23), (-0.2, -0.088, 0.088, 0.2))


@pytest.mark.parametrize("sections", [{"sections": 1}, {"sections": 4}, {"sections": 2, "borders": (1 / 3,)}])
@pytest.mark.parametrize("one_sided", [False, True])
@pytest.mark.parametrize("name", SHAPE_FUNCTIONS)
def test_free_bending_is_estimated_by_all(shipped_finger, name, sections, one_sided):
    """Within a hundredth of a radian at every joint, of a finger that bends 100 degrees; scalars or batches."""
    layout = SensorLayout(shipped_finger, **sections, one_sided=one_sided)
    pressure = np.array([[0.0, 50e3, 150e3]])
    q = free_bending_angles(shipped_finger, pressure)
    strain = layout.response.reading(extension_ratios(layout, q))
    shape = SHAPE_FUNCTIONS[name](layout, Uncertainty())(
        strain, shipped_finger.pressure_torque(pressure), np.zeros((1, 3))
    )
    np.testing.assert_allclose(shape.q, q, rtol=0, atol=1e-2)
    assert shape.points(shipped_finger).shape == (1, 3, 13)


def numbers(shape):
    """All arrays of an estimate."""
    curve = None if shape.curve is None else shape.curve.points
    alone = (shape.covariance, shape.external_torque, curve)
    return [shape.q, *(shape.contact or ()), *(each for each in alone if each is not None)]


@pytest.mark.parametrize("law", [None, SOFTENING], ids=["linear", "softening"])
@pytest.mark.parametrize("name", SHAPE_FUNCTIONS)
def test_samples_are_estimated_as_one_by_one(shipped_finger, name, law):
    """One force, the tip, two forces, none, a missing section, nothing that is read; by leading axes of two kinds.

    What is remembered of samples before is that of the first axis, so that only the second is taken apart.
    """
    finger = replace(shipped_finger, elastic_law=law)
    layout, gravity = SensorLayout(finger, 4), 9.81 * np.exp(1j * np.arange(6)).reshape(3, 2)
    pushes = [[Push(0.09, 0.8)], [Push(0.12, 0.6, 0.3)], [Push(0.05, 0.6), Push(0.1, 0.5)], [], [Push(0.08, -0.5)], []]
    q = [in_balance(finger, 40e3, g, p) for g, p in zip(gravity.reshape(-1), pushes, strict=True)]
    read = layout.response.reading(extension_ratios(layout, np.array(q))).reshape(3, 2, 8)
    read[2, 0, [1, 5]], read[2, 1] = np.nan, np.nan
    driving, estimate = finger.pressure_torque(np.full((3, 2), 40e3)), SHAPE_FUNCTIONS[name](layout, Uncertainty())
    found = numbers(estimate(read, driving, vector(gravity)))
    one_by_one = [(slice(None), j) for j in range(2)] if name == "recursive" else list(np.ndindex(3, 2))
    for index in one_by_one:
        alone = numbers(estimate(read[index], driving[index], vector(gravity[index])))
        for whole, part in zip(found, alone, strict=True):
            np.testing.assert_allclose(whole[index], part, rtol=1e-6, atol=1e-9)


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


@pytest.fixture(scope="module")
def contact(shipped_finger):
    return ContactShape(SensorLayout(shipped_finger, sections=2))


def bent_by_a_force(shape, samples):
    """Arguments of an estimator: readings of a finger that a force bends ever more, without pressure."""
    finger = shape.layout.finger
    q = np.linspace(-0.2, -0.201, samples)[:, None] * finger.angle((0.09 - finger.joint_arc_lengths).clip(0))
    return shape.layout.read(q), np.zeros_like(q), np.zeros((samples, 3))


def peak(function, *arguments):
    """Memory that a call takes at most, bytes."""
    tracemalloc.start()
    try:
        function(*arguments)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_a_long_recording_takes_memory_for_its_results_alone(contact):
    """Cells and densities of a sample, a hundred kilobytes, are no longer kept once its posterior is known."""
    few, many = (
        peak(contact.posterior, *bent_by_a_force(contact, samples)) for samples in (2 * _BATCH_SIZE, 4 * _BATCH_SIZE)
    )
    assert (many - few) / (2 * _BATCH_SIZE) < 2e3


def test_parts_give_what_all_samples_give(contact):
    """An interval that is computed part by part is the one computed when it is asked for."""
    given = bent_by_a_force(contact, _BATCH_SIZE + 4)
    together = contact.posterior(*given)
    for rows in (slice(0, _BATCH_SIZE), slice(_BATCH_SIZE, _BATCH_SIZE + 4)):
        part = contact.posterior(*(values[rows] for values in given))
        np.testing.assert_array_equal(part.force_interval, together.force_interval[rows])
        np.testing.assert_array_equal(part.force_bounds, together.force_bounds[rows])


@pytest.mark.parametrize("name", ["arcs", "gaussian", "contact", "recursive"])
def test_the_example_of_an_estimator_prints_what_it_says(name):
    found = doctest.testmod(import_module(f"soft_gripper.estimators.{name}"))
    assert (found.failed, found.attempted > 5) == (0, True)
