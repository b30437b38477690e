"""What a finger may have beside its cross-sections: a skin, laws of its own, creep, and a load at its tip."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.piecewise_linear import PiecewiseLinear


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


@dataclass(frozen=True)
class TipLoad:
    """A point mass that is fixed to the last link, in the bending plane."""

    mass: float  # kg
    x: float  # m, in the frame {finger}_tip, toward the inner side
    z: float  # m, in the frame {finger}_tip, beyond the tip
