"""Converts lengths of wires on both sides of an arm, (..., S) m, to bends, rad, and mid lengths, m, of its sections.

Two wires end with every section, one on the inner and one on the outer side, Delta_R apart. Their lengths along
their section, L_1 (inner) and L_2 (outer), are those of the wires less those of the wires that end one section
before. With the arcs of `estimators.arcs`, and corrections for a real arm,

    theta_s = (L_2 - L_1) / Delta_R + o_s + c_s theta_(s-1) ,   l_s = (L_1 + L_2) / 2 + a_s + b_s theta_s^2 ,

o and a are constant offsets of the wires, c is the share of the bend of the section before that the longer wires see,
as they pass it at another distance from its axis, and b is the excess length of a bent section over its straight wires.

Leading axes are free; S sections.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout


class Sections(NamedTuple):
    """Estimates of the sections from the wires, each (..., S)."""

    theta: Array  # rad
    length: Array  # m, midway between the wires


@dataclass(frozen=True)
class WireGeometry:
    """Courses of the wires of one arm, each (S,)."""

    spacing: float  # m, Delta_R
    bend_offsets: Array  # o, rad
    crossing: Array  # c; meaningless for the first section
    length_offsets: Array  # a, m
    bow: Array  # b, m/rad^2

    def sections(self, inner: Array, outer: Array) -> Sections:
        """Bends and mid lengths from wires that run from the base to the end of each section, (..., S) m each."""
        inner, outer = (np.diff(side, axis=-1, prepend=0.0) for side in (inner, outer))
        theta = (outer - inner) / self.spacing + self.bend_offsets
        for section in range(1, theta.shape[-1]):
            theta[..., section] += self.crossing[section] * theta[..., section - 1]
        return Sections(theta, (inner + outer) / 2 + self.length_offsets + self.bow * theta**2)


def as_strain(finger: Finger, theta: Array, sections: int) -> tuple[SensorLayout, Array]:
    """Two-sided sensors on an inextensible finger, and their strain at the bends theta, (..., S) rad.

    `sections`, which divides S, is the number of sensors per side: fewer than S see sums of bends.
    """
    bends = SensorLayout(finger, theta.shape[-1])
    q = bends.shared_equally(theta)
    layout = SensorLayout(finger, sections)
    return layout, layout.read(layout.shared_equally(layout.sums(q)))
