"""Points of an estimated curve."""

import numpy as np

from soft_gripper.estimators.arcs import join_arcs, sites_on_arcs

ARCS = join_arcs(np.array([0.4, -0.3, 0.0]), np.array([0.03, 0.05, 0.04]))


def test_arcs_begin_and_end_at_their_arc_lengths() -> None:
    ends = ARCS.length.cumsum()
    np.testing.assert_allclose(sites_on_arcs(ARCS, ends - ARCS.length)[0], ARCS.start, atol=1e-15)
    np.testing.assert_allclose(sites_on_arcs(ARCS, ends)[0], ARCS.end, atol=1e-15)


def test_between_them_the_heading_turns_evenly() -> None:
    _, headings = sites_on_arcs(ARCS, np.array([0.0, 0.015, 0.03, 0.055, 0.1]))
    np.testing.assert_allclose(headings, [0.0, 0.2, 0.4, 0.25, 0.1], atol=1e-15)


def test_the_point_moves_along_the_heading_and_those_beside_it_lie_across() -> None:
    s = np.array([0.01, 0.05, 0.1])
    points, headings = sites_on_arcs(ARCS, s)
    moved = (sites_on_arcs(ARCS, s + 1e-6)[0] - sites_on_arcs(ARCS, s - 1e-6)[0]) / 2e-6
    np.testing.assert_allclose(moved, np.exp(1j * headings), atol=1e-6)
    offset = np.array([0.01, 0.0, -0.02])
    beside, same = sites_on_arcs(ARCS, s, offset)
    np.testing.assert_allclose(beside - points, 1j * offset * np.exp(1j * headings), atol=1e-15)
    np.testing.assert_array_equal(same, headings)
