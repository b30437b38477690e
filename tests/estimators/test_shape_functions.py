"""The estimators by name: each is a function of arrays as the others."""

import numpy as np
import pytest

from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios


def test_names():
    assert list(SHAPE_FUNCTIONS) == ["arcs", "spline", "gaussian", "contact", "recursive", "constant_curvature"]


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


def test_uncertainty_is_taken_from_what_is_believed(shipped_finger):
    layout = SensorLayout(shipped_finger, 2)
    for name in ("gaussian", "contact"):
        little, much = (
            SHAPE_FUNCTIONS[name](layout, Uncertainty(reading=noise))(np.zeros(4), np.zeros(12), np.zeros(3)).covariance
            for noise in (1e-5, 1e-2)
        )
        assert (np.diagonal(much) > np.diagonal(little)).all()


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
