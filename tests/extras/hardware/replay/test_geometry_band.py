"""The band of an arm's bodies, and where an arm leaves what was fitted, against an arm that is known."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.extras.hardware.replay.geometry_band import body_band, extrapolations
from soft_gripper.extras.hardware.replay.geometry_fit import fit_geometry, measured, places


@pytest.fixture(scope="module")
def geometry(arms, arm_finger):
    return fit_geometry(arms[:3], arm_finger)


def stretched(arm, by, section=0):
    """The same with a section that is longer by a length, m, and wires that show it."""
    longer = by * (np.arange(arm.inner.shape[1]) >= section)
    return replace(arm, inner=arm.inner + longer, outer=arm.outer + longer)


def test_band_holds_what_was_never_seen(arms, arm_finger, geometry):
    theta, length = geometry.wires.sections(arms[3].inner, arms[3].outer)
    away = np.abs(places(geometry, arm_finger, theta, length)[0] - measured(arms[3], geometry.delay)[0])
    assert (away <= body_band(geometry, arms[3], arm_finger)).mean() > 0.9


def test_band_is_no_narrower_than_the_spread(arms, arm_finger, geometry):
    assert (body_band(geometry, arms[0], arm_finger) >= np.sqrt(5.991) * geometry.spread).all()


def test_band_is_as_wide_as_the_spread_where_nothing_else_is_uncertain(arms, arm_finger, geometry):
    """Known exactly, and within what was fitted: two bodies in a plane, so that 95 % lie within 2.45 deviations."""
    known = replace(geometry, variants=())
    band = body_band(known, arms[0], arm_finger)
    np.testing.assert_allclose(band, np.broadcast_to(np.sqrt(5.991) * geometry.spread, band.shape))
    assert (body_band(geometry, arms[0], arm_finger) < 0.01).all(), "of differences, while bodies are 0.25 m away"


def test_band_widens_with_the_distance_from_what_was_fitted(arms, arm_finger, geometry):
    within, near, far = (body_band(geometry, stretched(arms[0], by), arm_finger)[:, -1].mean() for by in (0, 0.1, 0.2))
    assert within < near < far
    assert far - near == pytest.approx(near - within, rel=0.5)


def test_a_section_that_is_longer_than_fitted_is_named(arms, geometry):
    assert not extrapolations(geometry, arms[0])
    (said,) = extrapolations(geometry, stretched(arms[0], 0.05))
    assert said.startswith("section 1 is ")
    assert " mm long, fitted from " in said
    (said,) = extrapolations(geometry, stretched(arms[0], 0.05, section=1))
    assert said.startswith("section 2 is ")
