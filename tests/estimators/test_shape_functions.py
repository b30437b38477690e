"""The estimators by name: each is a function of arrays as the others."""

from dataclasses import replace

import numpy as np
import pytest
from loaded_fingers import Push, in_balance, vector

from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
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


@pytest.mark.parametrize(("name", "uses"), [("arcs", False), ("spline", False), ("gaussian", True), ("contact", True)])
def test_positions_of_arcs_and_splines_use_geometry_alone(shipped_finger, bent, name, uses):
    """They depend neither on what drives the finger nor on what is assumed to be uncertain."""
    layout = SensorLayout(shipped_finger, 2)
    strain = layout.response.reading(extension_ratios(layout, bent(12) / 4))
    shapes = [
        SHAPE_FUNCTIONS[name](layout, Uncertainty(reading=noise))(
            strain, shipped_finger.pressure_torque(p), np.zeros(3)
        )
        for noise, p in ((1e-4, 0.0), (1e-2, 80e3))
    ]
    one, other = (shape.points(shipped_finger) for shape in shapes)
    assert (np.abs(one - other).max() > 1e-4) == uses


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
