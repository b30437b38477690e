"""Responses: a curve, piecewise linear and exactly invertible, and a gain and an offset for every sensor."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.mark.parametrize(
    "points",
    [
        [],
        [[1.0, 0.0]],
        [[1.0, 0.0], [1.0, 1.0]],
        [[1.0, 0.0], [2.0, 0.0]],
        [[2.0, 0.0], [1.0, 1.0]],
        [[1.0, 0.0], [2.0, float("nan")]],
        [[1.0, 0.0], [2.0]],
        [[1.0, 0.0, 2.0], [1.0, 3.0, 2.0]],
    ],
    ids=str,
)
def test_what_is_no_curve(points):
    with pytest.raises(InputError) as caught:
        ResponseCurve(points)
    assert str(caught.value).startswith(f"sensor: response = {points!r}: give at least two finite [")


def test_a_calibrated_response_and_its_inverse():
    response = CalibratedResponse(ResponseCurve(((0.9, -0.3), (1.0, 0.0), (1.1, 0.2))), (1.1, 0.9), (0.01, -0.01))
    reading = response.reading(np.array([[1.0, 1.1], [0.95, 1.0]]))
    np.testing.assert_allclose(reading, [[0.02, 0.16], [-0.135, -0.03]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(response.ratio(reading), [[1.0, 1.1], [0.95, 1.0]], rtol=0, atol=1e-14)


def test_a_curvature_is_undone_and_does_not_fold():
    response = CalibratedResponse(ResponseCurve(), (1.1, 0.9), (0.01, -0.01), curvature=-0.3)
    ratios = np.array([[1.0, 1.5], [0.7, 1.01]])
    strain = ratios - 1
    expected = np.array([1.1, 0.9]) * (strain - 0.3 * strain**2) + [0.01, -0.01]
    np.testing.assert_allclose(response.reading(ratios), expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(response.ratio(expected), ratios, rtol=0, atol=1e-14)
    assert np.isfinite(response.ratio(np.array([10.0, 10.0]))).all()


def test_it_fits_a_layout_of_as_many_readings(shipped_finger):
    response = CalibratedResponse(ResponseCurve(), (1.0,) * 4, (0.0,) * 4)
    assert SensorLayout(shipped_finger, 2, response=response).readings == 4
    with refused("gains", [1.0, 1.0, 1.0, 1.0]):
        SensorLayout(shipped_finger, 3, response=response)
