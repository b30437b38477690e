"""The band of an arm's bodies, and where an arm leaves what was fitted, against an arm that is known."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.extras.hardware.replay.geometry_band import body_band, disagreements, extrapolations, learn_band
from soft_gripper.extras.hardware.replay.geometry_fit import body_poses, fit_geometry, measured_poses, zero_geometry


@pytest.fixture(scope="module")
def fitted(arms, arm_finger):
    return fit_geometry(arms[:3], arm_finger)


@pytest.fixture(scope="module")
def geometry(fitted):
    return fitted.model


@pytest.fixture(scope="module")
def band(arms, arm_finger, fitted):
    return learn_band(fitted, arms[:3], arm_finger)


def stretched(arm, by, section=0):
    """The same with a section that is longer by a length, m, and wires that show it."""
    longer = by * (np.arange(arm.inner.shape[1]) >= section)
    return replace(arm, inner=arm.inner + longer, outer=arm.outer + longer)


def away(geometry, arm, finger):
    at, _ = body_poses(geometry, finger, *geometry.wires.sections(arm.inner, arm.outer))
    return np.abs(at - measured_poses(arm, geometry.delay)[0])


def test_band_holds_what_was_never_seen(arms, arm_finger, geometry, band):
    found = body_band(band, geometry, arms[3], arm_finger)
    assert (away(geometry, arms[3], arm_finger) <= found.radius).mean() > 0.9
    assert (found.radius < 0.01).all(), "of differences, while bodies are 0.25 m away"


def test_band_is_as_wide_as_the_errors_where_the_arm_was_fitted(arms, arm_finger, geometry, band):
    found = body_band(band, geometry, arms[0], arm_finger)
    errors = np.concatenate([away(geometry, arm, arm_finger) for arm in arms[:3]])
    np.testing.assert_allclose(found.radius, np.broadcast_to(np.quantile(errors, 0.95, axis=0), found.radius.shape))
    assert not found.is_far.any()
    assert not extrapolations(geometry, arms[0], found)


def test_band_widens_with_the_distance_from_what_was_fitted(arms, arm_finger, geometry, band):
    """As the root of it: a section that is three times as far longer moves the tip by the root of three more."""
    near, far = (body_band(band, geometry, stretched(arms[0], by), arm_finger) for by in (0.1, 0.3))
    floor = band.widths.floor[-1]
    grown = [np.sqrt(found.radius[:, -1] ** 2 - floor**2).mean() for found in (near, far)]
    assert 0 < grown[0] < grown[1]
    assert far.distance[:, 0].mean() == pytest.approx(3 * near.distance[:, 0].mean(), rel=0.2)
    assert grown[1] > 1.5 * grown[0]


def test_other_pressures_that_give_the_same_shape_do_not_widen_the_band(arms, arm_finger, geometry, band):
    """As those of another day; but they say that wires were set anew, where the shape is another than they gave."""
    found, other = (
        body_band(band, geometry, replace(arms[3], pressures=by * arms[3].pressures), arm_finger) for by in (1.0, 1.5)
    )
    np.testing.assert_array_equal(found.radius, other.radius)
    np.testing.assert_array_equal(found.is_far, other.is_far)


def test_a_section_that_leaves_what_was_fitted_is_named(arms, arm_finger, geometry, band):
    for section in range(2):
        moved = stretched(arms[0], 0.3, section)
        (said,) = extrapolations(geometry, moved, body_band(band, geometry, moved, arm_finger))
        assert said.startswith("100 % of it is far from what was fitted: ")
        assert f"section {section + 1} " in said


def test_wires_that_were_set_anew_disagree_with_the_drive(arms, geometry, band):
    assert not disagreements(band, geometry, arms[0])
    (said,) = disagreements(band, geometry, stretched(arms[0], 0.3, section=1))
    assert said.startswith("wires and pressures of section 2 disagree")


def test_zeroing_finds_the_offsets_of_wires_that_were_set_anew(arms, arm_finger, geometry, band):
    """Offsets of all four wires, of a centimetre or two, follow from half a second."""
    by = np.array([[0.02, -0.01], [0.012, -0.015]])
    anew = replace(arms[3], inner=arms[3].inner + by[0], outer=arms[3].outer + by[1])
    at = zero_geometry(geometry, anew, arm_finger, 0.5, band.std)
    assert away(geometry, anew, arm_finger).mean() > 0.01
    before = away(geometry, arms[3], arm_finger)
    after = away(at.geometry, anew, arm_finger)
    assert after.mean() < before.mean() + 5e-4
    found = body_band(band, at.geometry, anew, arm_finger, at.variants)
    assert (after <= found.radius).mean() > 0.9
    assert not disagreements(band, at.geometry, anew)
