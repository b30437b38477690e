"""Rubber: linear where strains are small, softer where it is stretched, stiffer where it is compressed."""

from dataclasses import replace

import numpy as np
import pytest

from studies.robustness.plants import rubber_moment


@pytest.mark.parametrize("end", ["base", "tip"])
def test_small_curvatures_meet_the_bending_stiffness(tapered_finger, end) -> None:
    section = getattr(tapered_finger, end)
    curvature = np.array([-1e-3, 1e-3])
    np.testing.assert_allclose(rubber_moment(section, curvature), section.bending_stiffness * curvature, rtol=2e-3)


def test_a_solid_strip_meets_the_series(shipped_finger) -> None:
    """Without layer and chamber the even terms cancel: M = E I k (1 + (4/3) k^2 <x^4> / <x^2>)."""
    solid = dict.fromkeys(("chamber_width", "chamber_thickness", "layer_thickness", "layer_modulus"), 0.0)
    section = replace(shipped_finger.base, **solid)
    curvature, h = np.array([2.0, 6.0]), section.thickness
    expected = section.bending_stiffness * curvature * (1 + 4 / 3 * curvature**2 * (h**4 / 80) / (h**2 / 12))
    np.testing.assert_allclose(rubber_moment(section, curvature), expected, rtol=5e-5)


def test_closing_softens_and_opening_stiffens(shipped_finger) -> None:
    curvature = np.array([-10.0, -5.0, 5.0, 10.0, 20.0])
    secant = rubber_moment(shipped_finger.base, curvature) / curvature
    assert (np.diff(secant) < 0).all()
    assert secant[1] > shipped_finger.base.bending_stiffness > secant[2]
