"""Arrows and bands of a drawn finger: where they lie."""

from functools import partial

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from soft_gripper.estimators.arcs import join_arcs
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, forward_kinematics, in_space
from soft_gripper.pictures.shape_figure import across_arcs, across_links, arrow_of_force, draw_band
from soft_gripper.truth.poses import corners

STRAIGHT = partial(across_arcs, join_arcs(np.zeros(12), np.full(12, 0.01)))


@pytest.mark.parametrize(("force", "face"), [(0.5, "inner_face"), (-0.5, "outer_face")])
def test_an_arrow_begins_at_the_face_and_is_25_mm_a_newton(shipped_finger: Finger, force: float, face: str) -> None:
    """Of a straight finger: across it is x."""
    arrow = arrow_of_force(shipped_finger, STRAIGHT, force, 0.08)
    assert arrow is not None
    np.testing.assert_allclose(arrow.begin, [float(getattr(shipped_finger.section(0.08), face)), 0.08])
    np.testing.assert_allclose(arrow.end - arrow.begin, [-0.025 * force, 0.0])


@pytest.mark.parametrize(("force", "s"), [(0.0, 0.08), (0.01, 0.08), (np.nan, 0.08), (1.0, np.nan)])
def test_what_is_no_force_has_no_arrow(shipped_finger: Finger, force: float, s: float) -> None:
    assert arrow_of_force(shipped_finger, STRAIGHT, force, s) is None


def test_points_beside_a_chain_are_those_of_its_links(shipped_finger: Finger) -> None:
    chain = forward_kinematics(np.linspace(0, 0.2, 12), shipped_finger.segment_length)
    ends = corners(in_space(chain.joints), in_space(chain.tip))
    offset = np.array([-0.01, 0.0, 0.02])
    for s in (*shipped_finger.joint_arc_lengths, 0.053, shipped_finger.length):
        expected = as_points(chain.at(np.full(3, s), offset).points)
        np.testing.assert_allclose(across_links(shipped_finger, ends, s, offset), expected, atol=1e-15)


def test_a_band_is_two_standard_deviations_wide_on_either_side(shipped_finger: Finger) -> None:
    axes, std = Figure().subplots(), np.linspace(0.1e-3, 1e-3, 13)
    draw_band(axes, np.stack([np.zeros(14), shipped_finger.link_ends], axis=-1), std)
    (band,) = (patch for patch in axes.patches if isinstance(patch, Polygon))
    inner, outer = np.split(band.get_xy(), 2)  # it ends where it begins
    np.testing.assert_allclose(inner[:, 0], 2e3 * np.concatenate([[0], std]))
    np.testing.assert_allclose(outer[::-1, 0], -inner[:, 0])
    np.testing.assert_allclose(inner[:, 1], 1e3 * shipped_finger.link_ends)
