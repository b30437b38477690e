"""Optional parts of a finger: skin, elastic and pressure laws, creep, a load at the tip."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.cross_section import SIZES
from soft_gripper.piecewise_linear import PiecewiseLinear
from soft_gripper.quantity import Violation, quantity, valid

# Deformations of the chain at a joint, and the axis about which it turns there, or along which it slides. Shear has a
# factor of its own; a finger names those of the others that it has.
AXES = {
    "shear": (1.0, 0.0, 0.0),
    "stretch": (0.0, 0.0, 1.0),
    "bending": (0.0, 1.0, 0.0),
    "sideways": (1.0, 0.0, 0.0),
    "twist": (0.0, 0.0, 1.0),
}
SLIDES = ("shear", "stretch")
YIELDS = tuple(deformation for deformation in AXES if deformation != "shear")
_SOFTENING_TOLERANCE = 1e-9
NO_PRESSURE = 1.0  # Pa, minimum at which the ratio of a pressure law is evaluated


def joint_order(yields: Sequence[str], segment: int) -> tuple[str, ...]:
    """Deformations of the joints in the middle of a segment, from the base to the tip.

    Turns about several axes do not commute. Their order is reversed in every other segment: in a fixed order, twist
    would act about the axis of one of the two links alone, and the error would fall with the segment length only, not
    with its square.
    """
    deformations = tuple(deformation for deformation in AXES if deformation in yields)
    return deformations[::-1] if segment % 2 else deformations


def _curve_violations(law: Any, columns: Sequence[str]) -> Iterator[Violation]:
    """Yields columns of a law that are not increasing numbers, as many as in the first."""
    row_count = len(getattr(law, columns[0]))
    for column in columns:
        values = getattr(law, column)
        if len(values) < 2 or len(values) != row_count or not np.all(np.diff(values) > 0):
            yield column, values, "must be increasing numbers, as many in each list, two or more"


@dataclass(frozen=True)
class ContactMaterial:
    """Contact properties of the finger's skin (Drake's hydroelastic parameters)."""

    friction: float = quantity(0.9, least=0, sizes=SIZES)  # Coulomb, equal static and dynamic
    # Of a link of a finger of 12 segments, whose skin is as stiff with any other number of them.
    hydroelastic_modulus: float = quantity(2e5, "Pa", above=0, sizes=SIZES)
    dissipation: float = quantity(3.0, "s/m", least=0, sizes=SIZES)  # Hunt and Crossley


@dataclass(frozen=True)
class ElasticLaw:
    """Bending moment against curvature as points, at base and tip; linear between them along the finger."""

    curvature: tuple[float, ...] = field(metadata=valid("1/m"))  # increasing
    base_moment: tuple[float, ...] = field(metadata=valid("N m"))  # increasing
    tip_moment: tuple[float, ...] = field(metadata=valid("N m"))  # increasing

    def violations(self) -> Iterator[Violation]:
        yield from _curve_violations(self, [column.name for column in fields(self)])


@dataclass(frozen=True)
class CreepBranch:
    """A Maxwell branch of a Prony series: a fraction of the stiffness that decays while the finger is held bent.

    Young's modulus is the instantaneous one. A step of the angle requires the torque
    k (1 - sum over branches of  share (1 - exp(-t / time))) q .
    """

    share: float = field(metadata=valid(above=0, sizes=SIZES))  # of the instantaneous stiffness
    time: float = field(metadata=valid("s", above=0, sizes=SIZES))  # time constant of the decay


@dataclass(frozen=True)
class PressureLaw:
    """Effects of pressure on a finger beyond the chamber law, as points, linear between them and beyond.

    With the effective pressure the chamber law gives the actual torque: a chamber that widens drives the finger more.
    Pressure may also take a fraction of the bending stiffness, as an axial force does of a column's
    (`fingers.taken_stiffness`).
    """

    pressure: tuple[float, ...] = field(metadata=valid("Pa"))  # increasing
    effective: tuple[float, ...] = field(metadata=valid("Pa"))  # increasing, and 0 at 0
    stiffness_taken: tuple[float, ...] = quantity((), below=1)  # shares, 0 at 0; empty: none. Negative: it stiffens

    def violations(self) -> Iterator[Violation]:
        yield from _curve_violations(self, ("pressure", "effective"))
        if 0 in self.pressure and self.effective[self.pressure.index(0)] != 0:
            yield "effective", self.effective, "must be 0 for 0: without pressure nothing bends"
        if self.stiffness_taken and len(self.stiffness_taken) != len(self.pressure):
            yield "stiffness_taken", self.stiffness_taken, "must be as many numbers as there are pressures, or none"
        elif self.stiffness_taken and self.share_taken(0.0) != 0:
            yield "stiffness_taken", self.stiffness_taken, "must be 0 for 0: without pressure the stiffness is whole"

    @cached_property
    def curve(self) -> PiecewiseLinear:
        """Effective pressure against pressure, Pa."""
        return PiecewiseLinear(np.array(self.pressure), np.array(self.effective))

    @cached_property
    def taken_fraction(self) -> PiecewiseLinear:
        """Fraction of the stiffness that pressure takes, against pressure, Pa."""
        zeros = (0.0,) * len(self.pressure)
        return PiecewiseLinear(np.array(self.pressure), np.array(self.stiffness_taken or zeros))

    @cached_property
    def widens(self) -> bool:
        """Whether the effective pressure is anything but proportional to the pressure."""
        ratios = self.softening(np.array(self.pressure))
        return bool(np.ptp(ratios) > _SOFTENING_TOLERANCE * np.abs(ratios).max())

    def softening(self, pressure: Array | float) -> Array:
        """Ratio of the torque to the torque of the chamber law alone, at pressures (...) Pa: P(p) / p."""
        divisor = np.where(np.abs(pressure) < NO_PRESSURE, NO_PRESSURE, pressure)
        return self.curve(divisor) / divisor

    def share_taken(self, pressure: Array | float) -> Array:
        """Fraction of the bending stiffness that pressures (...) Pa take."""
        return self.taken_fraction(np.asarray(pressure, dtype=float))

    def bend(self, pressure: Array | float) -> Array:
        """Pressure that bends a linear finger of the whole stiffness as far, (...) Pa: P / (1 - fraction)."""
        return self.curve(np.asarray(pressure, dtype=float)) / (1 - self.share_taken(pressure))


@dataclass(frozen=True)
class TipLoad:
    """A point mass fixed to the last link, in the bending plane."""

    mass: float = field(metadata=valid("kg", above=0, sizes=SIZES))
    x: float = field(metadata=valid("m", sizes=SIZES))  # in the frame {finger}_tip, toward the inner side
    z: float = field(metadata=valid("m", sizes=SIZES))  # in the frame {finger}_tip, beyond the tip


class LinkInertias(NamedTuple):
    """Mass properties of L rigid links, symmetric in y, each relative to its proximal end."""

    mass: Array  # (L,) kg
    center: Array  # (2, L) m, along x and z
    gyration: Array  # (3, L) m^2, squares of the radii of gyration about the centre along x, y and z
    product: Array  # (L,) m^2, mean of x z about the centre

    @property
    def tensors(self) -> Array:
        """Inertia about the centre, kg m^2, (L, 3, 3)."""
        x, y, z = self.gyration
        zero = np.zeros(self.mass.shape)
        rows = [[y + z, zero, -self.product], [zero, x + z, zero], [-self.product, zero, x + y]]
        return self.mass[:, None, None] * np.moveaxis(np.array(rows), -1, 0)

    def with_load(self, mass: float, position: Array) -> "LinkInertias":
        """Copy with a point mass (kg) fixed to the last link, at `position`, (2,) m along x and z."""
        is_last = np.arange(len(self.mass)) == len(self.mass) - 1
        fraction = is_last * mass / (self.mass + mass)
        distance = position - self.center[:, -1]
        x, z = distance
        gyration = self.gyration + np.outer([x**2, 0.0, z**2], fraction)
        product = self.product + x * z * fraction
        center = self.center + np.outer(distance, fraction)
        return LinkInertias(self.mass + is_last * mass, center, (1 - fraction) * gyration, (1 - fraction) * product)
