"""What a finger may have beside its cross-sections: a skin, laws, creep, a load at its tip; what its numbers may be."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.piecewise_linear import PiecewiseLinear

NO_PRESSURE = 1.0  # Pa, below which a pressure law is as there
_MAY_BE_ZERO = (
    *("relaxation_time", "friction", "dissipation", "shear_factor"),
    *("chamber_width", "chamber_thickness", "layer_thickness", "layer_modulus"),
)
_OF_ANY_SIGN = ("chamber_center", "x", "z")
_LEAST, _MOST = 1e-9, 1e12  # of the size of a number that is not 0; beyond, what follows from it leaves the range


@dataclass(frozen=True)
class ContactMaterial:
    """How the finger's skin meets what it touches (Drake's hydroelastic contact parameters)."""

    friction: float = 0.9  # Coulomb, static and dynamic alike
    hydroelastic_modulus: float = 2e5  # Pa
    dissipation: float = 3.0  # s/m, Hunt and Crossley


@dataclass(frozen=True)
class ElasticLaw:
    """Bending moment against curvature as points, at base and tip; linear between them along the finger."""

    curvature: tuple[float, ...]  # 1/m, increasing
    base_moment: tuple[float, ...]  # N m, increasing
    tip_moment: tuple[float, ...]  # N m, increasing


@dataclass(frozen=True)
class CreepBranch:
    """A Maxwell branch of a Prony series: a part of the stiffness that fades while the finger is held bent.

    Young's modulus is the instantaneous one. A step of the angle calls up
    k (1 - sum over branches of  share (1 - exp(-t / time))) q .
    """

    share: float  # of the instantaneous stiffness
    time: float  # s, in which it fades to 1 / e


@dataclass(frozen=True)
class PressureLaw:
    """The pressure that bends as much by the chamber law, against the pressure in the chamber, as points.

    Linear between the points, and straight on beyond them. So a chamber that widens under pressure bends further.
    """

    pressure: tuple[float, ...]  # Pa, increasing
    effective: tuple[float, ...]  # Pa, increasing, and 0 at 0

    @cached_property
    def curve(self) -> PiecewiseLinear:
        """Effective pressure against pressure, Pa."""
        return PiecewiseLinear(np.array(self.pressure), np.array(self.effective))

    def softening(self, pressure: Array | float) -> Array:
        """How many times as far as by the chamber law alone the finger bends, at pressures (...) Pa: P(p) / p."""
        some = np.where(np.abs(pressure) < NO_PRESSURE, NO_PRESSURE, pressure)
        return self.curve(some) / some


@dataclass(frozen=True)
class TipLoad:
    """A point mass that is fixed to the last link, in the bending plane."""

    mass: float  # kg
    x: float  # m, in the frame {finger}_tip, toward the inner side
    z: float  # m, in the frame {finger}_tip, beyond the tip


class LinkInertias(NamedTuple):
    """The masses of L rigid links, each seen from where it begins."""

    mass: Array  # (L,) kg
    center: Planar  # (L,) m, z + i x
    gyration: Array  # (3, L) m^2, squares of the radii of gyration about the centre along x, y and z
    product: Array  # (L,) m^2, mean of x z about the centre

    def loaded(self, mass: float, place: complex) -> "LinkInertias":
        """With a point mass (kg) fixed to the last link, at `place` (m, z + i x)."""
        is_last = np.arange(len(self.mass)) == len(self.mass) - 1
        share, away = is_last * mass / (self.mass + mass), place - complex(self.center[-1])
        x, z = away.imag, away.real
        gyration = self.gyration + np.outer([x**2, 0.0, z**2], share)
        product = self.product + x * z * share
        return LinkInertias(
            self.mass + is_last * mass, self.center + share * away, (1 - share) * gyration, (1 - share) * product
        )


def out_of_range(name: str, value: float) -> str | None:
    """What a number of a finger or of one of its parts would have to be; None if it is."""
    least, allowed = "above 0", value > 0
    if name in _MAY_BE_ZERO:
        least, allowed = "of at least 0", value >= 0
    if name in _OF_ANY_SIGN:
        least, allowed = "", True
    if not np.isfinite(value) or not allowed:
        return f"give a finite number {least}".strip()
    if value != 0 and not _LEAST <= abs(value) <= _MOST:
        return f"give a number of {_LEAST:g} to {_MOST:g} in size"
    return None
