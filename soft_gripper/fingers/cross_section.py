"""The cross-section of a finger as built, and derived quantities: bending stiffness, neutral axis, chamber law.

Seen along the finger, with the inner side, which touches, to the right:

    outer face                                    inner face
        +---------------------------------------+=+
        |          +----------------+           | |   ^ y
        |          |    chamber     |           | |   |
        |          +----------------+           |=|   +--> x, from the middle of the outer section
        +---------------------------------------+=+
                                       strain-limiting layer

Plane sections stay plane (Euler and Bernoulli), so a composite bends about the centroid of its moduli:

    x_n = sum E_i A_i x_i / sum E_i A_i ,    EI = sum E_i (I_i + A_i (x_i - x_n)^2) ,

summed over the block of silicone, the chamber (which takes silicone away) and the layer (which takes its place). All
are symmetric in y, so bending sideways is about the middle of each, and independent of bending in the plane. For twist
see `torsion`.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.torsion import Rectangle, torsional_stiffness
from soft_gripper.quantity import Violation, quantity, valid

SIZES = (1e-9, 1e12)  # range of nonzero parameters of a finger; beyond it, derived quantities would overflow
Quantity = Array | float  # at one or several positions along the finger


class Hole(NamedTuple):
    """A rectangle without material."""

    width: Quantity  # m, along y
    thickness: Quantity  # m, along x
    x: Quantity  # m, of its middle, from the middle of the outer section
    y: Quantity = 0.0  # m, likewise

    @property
    def area(self) -> Quantity:
        """m^2."""
        return self.width * self.thickness


@dataclass(frozen=True)
class CrossSection:
    """Construction of the finger at one position along its length, or at several if the fields are arrays (SI units).

    Without a chamber the section is solid; without a layer it is silicone alone.
    """

    width: float = field(metadata=valid("m", above=0, sizes=SIZES))  # outer, along the bending axis y
    thickness: float = field(metadata=valid("m", above=0, sizes=SIZES))  # outer, along the inner normal x
    youngs_modulus: float = field(metadata=valid("Pa", above=0, sizes=SIZES))  # of the silicone
    density: float = field(metadata=valid("kg/m^3", above=0, sizes=SIZES))  # of the silicone
    chamber_width: float = quantity(0.0, "m", least=0, sizes=SIZES)  # along y
    chamber_thickness: float = quantity(0.0, "m", least=0, sizes=SIZES)  # along x
    # Along x from the middle of the outer section; negative toward the outer face.
    chamber_center: float = quantity(0.0, "m", sizes=SIZES)
    # Of a strain-limiting layer in the inner face, as wide as the finger.
    layer_thickness: float = quantity(0.0, "m", least=0, sizes=SIZES)
    layer_modulus: float = quantity(0.0, "Pa", least=0, sizes=SIZES)  # Young's modulus of that layer
    # Of that layer, in its plane; 0: isotropic and incompressible, a third of its Young's modulus.
    layer_shear_modulus: float = quantity(0.0, "Pa", least=0, sizes=SIZES)

    @cached_property
    def chamber_area(self) -> Quantity:
        """m^2."""
        return self.chamber_width * self.chamber_thickness

    @cached_property
    def area(self) -> Quantity:
        """Solid area, m^2."""
        return self.width * self.thickness - sum(hole.area for hole in self.holes)

    @property
    def holes(self) -> tuple[Hole, ...]:
        """Hollow parts of the section: its chamber."""
        return (Hole(self.chamber_width, self.chamber_thickness, self.chamber_center),)

    @cached_property
    def _parts(self) -> list[tuple[Quantity, ...]]:
        """Modulus, width, thickness and centre (x, y) of the summed parts: block, holes, layer."""
        layer = (self.layer_modulus - self.youngs_modulus, self.width, self.layer_thickness, self.layer_center, 0.0)
        block = (self.youngs_modulus, self.width, self.thickness, 0.0, 0.0)
        return [block, *((-self.youngs_modulus, *hole) for hole in self.holes), layer]

    @property
    def layer_center(self) -> Quantity:
        """m, along x from the middle of the outer section."""
        return (self.thickness - self.layer_thickness) / 2

    @cached_property
    def neutral_axis(self) -> Quantity:
        """Axis that keeps its length in bending, m along x from the middle of the outer section."""
        return sum(E * w * t * x for E, w, t, x, _ in self._parts) / self.stretch_stiffness

    @cached_property
    def bending_stiffness(self) -> Quantity:
        """E I about the neutral axis, N m^2."""
        return sum(E * w * t * (t**2 / 12 + (x - self.neutral_axis) ** 2) for E, w, t, x, _ in self._parts)

    @cached_property
    def sideways_stiffness(self) -> Quantity:
        """E I about the axis of symmetry, of bending out of the plane, N m^2."""
        return sum(E * w**3 * t / 12 + E * w * t * y**2 for E, w, t, _, y in self._parts)

    @cached_property
    def twist_stiffness(self) -> Quantity:
        """G J, N m^2; silicone is incompressible, G = E / 3."""
        layer_shear_modulus = np.where(self.layer_shear_modulus == 0, self.layer_modulus / 3, self.layer_shear_modulus)
        block = (self.youngs_modulus / 3, self.width, self.thickness)
        layer = (layer_shear_modulus, self.layer_thickness, self.layer_center)
        return _twist_stiffness(*block, *layer, *(number for hole in self.holes for number in hole))

    @cached_property
    def stretch_stiffness(self) -> Quantity:
        """E A, N."""
        return sum(E * w * t for E, w, t, _, _ in self._parts)

    @cached_property
    def chamber_eccentricity(self) -> Quantity:
        """Distance from the chamber's centroid to the neutral axis, m; positive where pressure closes the finger."""
        return self.neutral_axis - self.chamber_center

    @property
    def inner_face(self) -> Quantity:
        """m, along x from the neutral axis."""
        return self.thickness / 2 - self.neutral_axis

    @property
    def outer_face(self) -> Quantity:
        """m, along x from the neutral axis; negative."""
        return -self.thickness / 2 - self.neutral_axis

    @cached_property
    def mass_center(self) -> Quantity:
        """m, along x from the neutral axis. The layer counts as silicone."""
        return -sum(hole.area * hole.x for hole in self.holes) / self.area - self.neutral_axis

    @cached_property
    def gyration(self) -> tuple[Quantity, Quantity]:
        """Squares of the radii of gyration of the mass about its centre, along x and along y, m^2."""
        center = self.mass_center + self.neutral_axis
        block = self.width * self.thickness
        along_x = block * (self.thickness**2 / 12 + center**2)
        along_x = along_x - sum(hole.area * (hole.thickness**2 / 12 + (hole.x - center) ** 2) for hole in self.holes)
        along_y = block * self.width**2 / 12 - sum(h.area * (h.width**2 / 12 + h.y**2) for h in self.holes)
        return along_x / self.area, along_y / self.area

    @property
    def walls(self) -> dict[str, Quantity]:
        """Thickness of the walls round the chamber, m: at each side, outer and inner (of silicone, without layer)."""
        half, middle = self.chamber_thickness / 2, self.chamber_center
        return {
            "side": (self.width - self.chamber_width) / 2,
            "outer": self.thickness / 2 + middle - half,
            "inner": self.thickness / 2 - middle - half - self.layer_thickness,
        }

    def violations(self) -> Iterator[Violation]:
        """Dimensions that cannot be moulded: field, value, and the valid range."""
        if (self.chamber_width == 0) != (self.chamber_thickness == 0):
            yield "chamber_width", self.chamber_width, "a chamber has a width and a thickness, a solid section neither"
        if (self.layer_thickness == 0) != (self.layer_modulus == 0):
            yield "layer_modulus", self.layer_modulus, "a layer has a thickness and a modulus"
        if self.layer_shear_modulus > 0 and self.layer_thickness == 0:
            yield "layer_shear_modulus", self.layer_shear_modulus, "leave it out: there is no layer"
        if self.layer_thickness >= self.thickness:
            yield "layer_thickness", self.layer_thickness, f"give less than the thickness, {self.thickness:g} m"
        if self.chamber_area == 0:
            return
        field = {"side": "chamber_width", "outer": "chamber_center", "inner": "chamber_center"}
        walls = ", ".join(f"{name} {1e3 * wall:.2f} mm" for name, wall in self.walls.items())
        for name, wall in self.walls.items():
            if wall <= 0:
                expected = f"the chamber does not fit; it leaves walls of {walls}"
                yield field[name], getattr(self, field[name]), expected
        if self.chamber_eccentricity <= 0:
            expected = f"pressure would open the finger: give less than the neutral axis, {self.neutral_axis:.3g} m"
            yield "chamber_center", self.chamber_center, expected


@dataclass(frozen=True)
class PiercedSection(CrossSection):
    """A section pierced by the finger's chambers, in place of one chamber of the section; mirrored in y."""

    bores: tuple[Hole, ...] = ()

    @property
    def holes(self) -> tuple[Hole, ...]:
        return self.bores


@dataclass(frozen=True)
class Station(CrossSection):
    """A cross-section between the base and the tip."""

    at: float = field(kw_only=True, metadata=valid(above=0, below=1))  # place, as a share of the finger's length


@np.vectorize
def _twist_stiffness(
    shear_modulus: float,
    width: float,
    thickness: float,
    layer_shear_modulus: float,
    layer_thickness: float,
    layer_center: float,
    *holes: float,
) -> float:
    block = Rectangle(shear_modulus, width, thickness, 0.0)
    hollow = [Rectangle(0.0, w, t, x, abs(y)) for w, t, x, y in zip(*(holes[i::4] for i in range(4)), strict=True)]
    layer = Rectangle(layer_shear_modulus, width, layer_thickness, layer_center)
    return torsional_stiffness((block, *hollow, layer))
