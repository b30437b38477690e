"""The arc model of a finger: sensor lengths -> one circular arc a section -> the whole curve.

Equations (2) to (6) of the paper, with errors in its (3) and (6) corrected, for a section whose paths measure L_1
(inner) and L_2 (outer) and run Delta_R apart:

    (2)  L_i = lambda_i L_0i                 length by the extension ratio, of a path that is L_0i at rest
         R_2 = R_1 + Delta_R                 the paths are arcs about one centre; no number in the paper
    (3)  L_1 = R_1 theta ,  L_2 = R_2 theta  length of an arc
    (4)  R_1 = L_1 Delta_R / (L_2 - L_1)     from both; singular where the finger is straight
    (5)  R_2 = L_2 Delta_R / (L_2 - L_1)     from both; here R = R_1 + Delta_R / 2, of the axis between the paths
    (6)  theta = L_1 / R_1                   bend of the section

Eliminating the radii leaves what `arcs_from_lengths` computes, smooth through zero, so that no case is special:

    theta = (L_2 - L_1) / Delta_R ,   l = (L_1 + L_2) / 2 ,   kappa = theta / l = 1 / R

The bends of a finger that is bent by 60 kPa, from its readings:

    >>> import numpy as np
    >>> import soft_gripper as sg
    >>> finger = sg.make_station(sg.load_scenario("free_bending")).fingers[0].finger
    >>> layout = sg.sensors.SensorLayout(finger, sections=4)
    >>> readings = layout.read(sg.fingers.free_bending_angles(finger, 60e3))
    >>> arcs = sg.estimators.arcs_from_readings(layout, readings)
    >>> print(np.degrees(arcs.theta).round(2))
    [9.23 9.35 9.47 9.6 ]

Shapes: leading axes are free, S sections. Planar vectors are complex, z + i x (see `kinematics`).

Symbols: L_1, L_2 lengths measured on the inner and on the outer side, m; R_1, R_2, R radii of the paths and of the
axis, m; Delta_R distance of the paths, m; theta bend of a section, rad; l its length on the axis, m; kappa its
curvature, 1/m.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.kinematics import planar_vector, rotated, unit_vectors
from soft_gripper.sensors.sensor_layout import SensorLayout

_TINY = 1e-100  # lost in any other number; added to 0 it makes sin(x) / x exactly 1


class Arcs(NamedTuple):
    """Arcs joined end to end from the base of the finger, each (..., S)."""

    theta: Array  # rad, bend of each arc, positive when closing
    length: Array  # m, along the axis of the finger
    heading: Array  # rad, tangent where the arc begins
    start: Planar  # m in B, where it begins
    end: Planar  # m in B, where it ends

    @property
    def kappa(self) -> Array:
        """Curvature of each arc, 1/m."""
        return self.theta / self.length

    @property
    def centers(self) -> Planar:
        """Centre of each arc, m in B; NaN where the arc is straight and has none."""
        radius = self.length / np.where(self.theta == 0, np.nan, self.theta)
        return self.start + 1j * radius * unit_vectors(self.heading)

    @property
    def tip_heading(self) -> Array:
        """Tangent at the end of the last arc, rad, (...)."""
        return self.heading[..., -1] + self.theta[..., -1]


def chord(theta: Array, length: Array, heading: Array) -> Planar:
    """Vector from the beginning to the end of an arc; exact for every angle, zero included."""
    half_angle = theta / 2 + _TINY
    return length * (np.sin(half_angle) / half_angle) * unit_vectors(heading + half_angle)


def join_arcs(theta: Array, length: Array) -> Arcs:
    """Arcs of angles `theta` and lengths `length`, one after the other from the base."""
    heading = theta.cumsum(axis=-1) - theta
    step = chord(theta, length, heading)
    end = step.cumsum(axis=-1)
    return Arcs(theta, length, heading, end - step, end)


def arcs_from_lengths(inner: Array, outer: Array, spacing: float, axis_at: float = 0.5) -> Arcs:
    """The arcs of `bends_from_lengths`, one after the other from the base."""
    return join_arcs(*bends_from_lengths(inner, outer, spacing, axis_at))


def bends_from_lengths(inner: Array, outer: Array, spacing: float, axis_at: float = 0.5) -> tuple[Array, Array]:
    """Equations (2)-(6): bends, rad, and lengths, m, of arcs with paths of `inner` and `outer` m, each (..., S).

    `spacing` is the distance between the paths, m; `axis_at` says where between them the neutral axis of the
    finger runs (0: on the inner path, 1: on the outer, below 0: beyond the inner one). A length that is NaN makes its
    own arc NaN and the start of all that follow: what hangs on an unknown arc is unknown.
    """
    difference = outer - inner
    return difference / spacing, inner + axis_at * difference


def points_on_arcs(
    arcs: Arcs, section: NDArray[np.int_], fraction: Array, offset: Array | float | None = None
) -> Planar:
    """Points at `fraction` (0 to 1) of the arcs of index `section`, both (M,) -> (..., M) m in B.

    `offset` (..., M) m is their distance from the axis, positive on the inner side; None: they lie on it.
    """
    theta = arcs.theta.take(section, axis=-1) * fraction
    length = arcs.length.take(section, axis=-1) * fraction
    heading, start = arcs.heading.take(section, axis=-1), arcs.start.take(section, axis=-1)
    points = start + chord(theta, length, heading)
    return points if offset is None else points + rotated(planar_vector(offset, 0.0), heading + theta)


def arcs_from_readings(layout: SensorLayout, readings: Array) -> Arcs:
    """The arcs of a finger, (..., S), from its sensor readings, (..., paths * S).

    A reading that is NaN or infinite makes its arc NaN, and the place of all that follow.
    """
    return join_arcs(*bends_from_readings(layout, readings))


def bends_from_readings(layout: SensorLayout, readings: Array) -> tuple[Array, Array]:
    """Bends, rad, and lengths, m, that `arcs_from_readings` joins, each (..., S)."""
    ratios = layout.response.ratio(np.where(np.isfinite(readings), readings, np.nan))
    lengths = ratios.reshape(*readings.shape[:-1], layout.paths, layout.sections) * layout.rest_lengths
    inner, axis = (layout.rest_lengths, 0.0) if layout.one_sided else (lengths[..., 0, :], layout.offsets[0])
    spacing = axis - layout.offsets[-1]
    return bends_from_lengths(inner, lengths[..., -1, :], spacing, axis_at=axis / spacing)


def joints_on_arcs(layout: SensorLayout, arcs: Arcs) -> Planar:
    """The simulation's joints re-mapped onto the estimated curve, (..., N) m in B."""
    return points_on_arcs(arcs, layout.joint_sections, layout.joint_fractions)


@dataclass(frozen=True)
class ArcCurve:
    """The curve of a finger as arcs, one a section; joined when it is asked for."""

    layout: SensorLayout
    theta: Array  # rad, bend of each section, (..., S)
    length: Array  # m, of its axis, (..., S)

    @cached_property
    def arcs(self) -> Arcs:
        return join_arcs(self.theta, self.length)

    @cached_property
    def joints(self) -> Planar:
        return joints_on_arcs(self.layout, self.arcs)

    @property
    def tip(self) -> Planar:
        return self.arcs.end[..., -1]

    @property
    def tip_heading(self) -> Array:
        return self.arcs.tip_heading

    @property
    def points(self) -> Planar:
        """Joints and tip, (..., N + 1) m."""
        return np.concatenate([self.joints, self.arcs.end[..., -1:]], axis=-1)

    def at(self, rows: NDArray[np.int_]) -> "ArcCurve":
        """The curves of some samples, by their numbers along the first axis."""
        return ArcCurve(self.layout, self.theta[rows], self.length[rows])
