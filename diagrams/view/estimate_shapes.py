"""Where the shapes go that stand for an estimated curve: its pieces and points, circles and radii of its arcs."""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import Arcs, join_arcs, points_on_arcs


def arcs_of_table(table: Array) -> Arcs:
    """The arcs in a reshaped `arcs` port of an estimator, (S, 7)."""
    _, _, _, kappa, length, _, _ = table.T
    return join_arcs(kappa * length, length)


def curve_pieces(arcs: Arcs, pieces: int) -> tuple[Planar, Array]:
    """Middles (m in B) and headings (rad) of the chords of each arc's equal `pieces`, (S * pieces).

    Pieces that are not known lie on the last one that is, so that the curve ends there.
    """
    sections, ends = np.arange(len(arcs.theta)), np.linspace(0, 1, pieces + 1)
    points = points_on_arcs(arcs, np.repeat(sections, pieces + 1), np.tile(ends, len(sections)))
    points = points.reshape(len(sections), pieces + 1)
    middles = (points[:, :-1] + points[:, 1:]) / 2
    headings = arcs.heading[:, None] + arcs.theta[:, None] * (ends[:-1] + ends[1:]) / 2
    known = np.isfinite(headings.ravel())
    last = np.maximum.accumulate(np.where(known, np.arange(known.size), 0))
    return np.nan_to_num(middles.ravel()[last]), np.nan_to_num(headings.ravel()[last])


def point_at(arcs: Arcs, s: float) -> tuple[complex, float]:
    """The point at arc length s, m, as z + i x in B, and the heading there, rad; on the last arc beyond its end."""
    ends = np.cumsum(arcs.length)
    i = min(int(np.searchsorted(ends, s)), len(ends) - 1)
    fraction = (s - (ends[i] - arcs.length[i])) / arcs.length[i]
    (point,) = points_on_arcs(arcs, np.array([i]), np.array([fraction]))
    return complex(point), float(arcs.heading[i] + fraction * arcs.theta[i])


def arc_frames(arcs: Arcs) -> tuple[Planar, Array, Array]:
    """Centres (m in B) of the arcs, headings (rad) of the radii to where they begin, and radii (m), each (S)."""
    headings = arcs.heading - np.sign(arcs.theta) * np.pi / 2
    return arcs.centers, headings, np.abs(arcs.start - arcs.centers)


def unit_circle(edges: int = 96) -> Array:
    """A circle of radius 1 m about y, (3, edges + 1) corners."""
    angle = np.linspace(0, 2 * np.pi, edges + 1)
    return np.array([np.sin(angle), np.zeros_like(angle), np.cos(angle)])
