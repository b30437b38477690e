"""Wires of a bent and lengthened arm, and what is read from them."""

import numpy as np

from soft_gripper.extras.hardware.replay.wire_lengths import WireGeometry

SPACING = 0.04


def calibration(**numbers):
    zeros = {name: np.zeros(2) for name in ("bend_offsets", "crossing", "length_offsets", "bow")}
    return WireGeometry(spacing=SPACING, **{**zeros, **numbers})


def wires(theta, length):
    """Arcs about one centre: each side is as much longer or shorter as its radius; wires add up from the base."""
    inner, outer = length - theta * SPACING / 2, length + theta * SPACING / 2
    return inner.cumsum(axis=-1), outer.cumsum(axis=-1)


def test_constant_offsets_of_wires_are_taken_off():
    theta, length = np.array([0.5, -0.7]), np.array([0.12, 0.15])
    inner, outer = wires(theta, length)
    shifted = inner + np.array([0.004, 0.002]), outer + np.array([-0.002, 0.006])
    offsets = np.array([0.006, -0.010]) / SPACING  # 4 and -2 mm along the inner, -2 and 8 mm along the outer side
    found = calibration(bend_offsets=offsets, length_offsets=np.array([-0.001, -0.003])).sections(*shifted)
    np.testing.assert_allclose(found.theta, theta, atol=1e-12)
    np.testing.assert_allclose(found.length, length, atol=1e-12)


def test_of_three_sections_each_is_passed_by_the_wires_of_the_next():
    """Wires that see a tenth of the bend before theirs, and run 2 mm short at one radian, bent either way."""
    theta, length, zeros = np.array([0.5, -0.7, 0.4]), np.array([0.12, 0.15, 0.13]), np.zeros(3)
    seen = theta + 0.1 * np.array([0.0, *theta[:2]])
    crossing, bow = np.array([0.0, -0.1, -0.1]), np.full(3, 2e-3)
    found = WireGeometry(SPACING, zeros, crossing, zeros, bow).sections(*wires(seen, length - 2e-3 * theta**2))
    np.testing.assert_allclose(found.theta, theta, atol=1e-12)
    np.testing.assert_allclose(found.length, length, atol=1e-12)
