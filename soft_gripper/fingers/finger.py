"""A soft finger as physical parameters, and the chain of rigid segments that stands for it."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.piecewise_linear import PiecewiseLinear


@dataclass(frozen=True)
class CrossSection:
    """What the finger is made of at one place along its length (SI units)."""

    width: float  # m, along the bending axis y
    thickness: float  # m, along the inner normal x
    youngs_modulus: float  # Pa
    density: float  # kg/m^3, effective (mass over outer volume)
    chamber_area: float  # m^2, cross-section of the pressure chamber
    chamber_eccentricity: float  # m, from the neutral axis to the chamber's centroid


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
class Finger:
    """A finger of `length` m in `segments` equal segments, a joint in the middle of each.

    Joints in the middles are the midpoint rule: the chain converges to the beam with the square of the
    segment length, and every joint belongs to exactly one sensor section. Frame B sits at the base with +z
    along the straight finger and +x toward the object; a positive joint angle closes the finger.

    Raises:
        InputError: if a field is not finite or out of range.
    """

    name: str
    length: float
    base: CrossSection
    tip: CrossSection
    sensor_spacing: float  # m, between inner and outer sensor path (Delta_R)
    segments: int = 12
    relaxation_time: float = 0.015  # s, Kelvin-Voigt: damping over stiffness
    contact: ContactMaterial = ContactMaterial()
    elastic_law: ElasticLaw | None = None  # in the place of E I times curvature

    def __post_init__(self) -> None:
        if not isinstance(self.segments, int | np.integer) or self.segments < 1:
            self._reject("segments", self.segments, "give a whole number of at least 1")
        for label, part in (("", self), ("base.", self.base), ("tip.", self.tip), ("contact.", self.contact)):
            for field in fields(part):
                value = getattr(part, field.name)
                if isinstance(value, int | float):
                    self._require_in_range(label + field.name, value)
        if self.elastic_law is not None:
            self._check_elastic_law(self.elastic_law)

    def _check_elastic_law(self, law: ElasticLaw) -> None:
        for field in fields(law):
            values = getattr(law, field.name)
            increasing = np.isfinite(values).all() and np.all(np.diff(values) > 0)
            if len(values) < 2 or len(values) != len(law.curvature) or not increasing:
                self._reject(f"elastic_law.{field.name}", values, "give as many increasing numbers in each list")

    def _require_in_range(self, field: str, value: float) -> None:
        may_be_zero = field in ("relaxation_time", "contact.friction", "contact.dissipation")
        if not np.isfinite(value) or value < 0 or (value == 0 and not may_be_zero):
            self._reject(field, value, "give a finite number " + ("of at least 0" if may_be_zero else "above 0"))

    def _reject(self, field: str, value: object, expected: str) -> None:
        raise InputError(f"finger '{self.name}'", field, value, expected)

    @property
    def segment_length(self) -> float:
        return self.length / self.segments

    @cached_property
    def joint_arc_lengths(self) -> Array:
        """Arc length s of every joint from the base, m, shape (N,)."""
        return (np.arange(self.segments) + 0.5) * self.segment_length

    def interpolate(self, quantity: str, s: Array) -> Array:
        """A quantity of the cross-section at arc lengths `s` (m), linear from base to tip."""
        ends = [getattr(self.base, quantity), getattr(self.tip, quantity)]
        return np.interp(s, [0.0, self.length], ends)

    @cached_property
    def stiffness(self) -> Array:
        """Bending stiffness of every joint, k_i = E I(s_i) / ds, N m/rad, shape (N,)."""
        s = self.joint_arc_lengths
        second_moment = self.interpolate("width", s) * self.interpolate("thickness", s) ** 3 / 12
        return self.interpolate("youngs_modulus", s) * second_moment / self.segment_length

    def elastic_torque(self, q: Array) -> Array:
        """Torque that joint angles (..., N) rad call up against them, N m, (..., N)."""
        return self.stiffness * q if self.elastic_law is None else self.joint_law(q)

    def angle(self, torque: Array) -> Array:
        """Joint angles at which the elastic torque is `torque`, (..., N) N m -> rad."""
        return torque / self.stiffness if self.elastic_law is None else self.joint_law.inverse()(torque)

    @cached_property
    def joint_law(self) -> PiecewiseLinear:
        """Torque against angle of every joint: the elastic law, or the straight line of the stiffness."""
        law = self.elastic_law
        if law is None:
            ends = np.outer(np.ones(self.segments), [-1.0, 1.0])
            return PiecewiseLinear(ends, ends * self.stiffness[:, None])
        along = (self.joint_arc_lengths / self.length)[:, None]
        torques = (1 - along) * np.array(law.base_moment) + along * np.array(law.tip_moment)
        angles = np.array(law.curvature) * self.segment_length
        return PiecewiseLinear(np.broadcast_to(angles, torques.shape), torques)

    @cached_property
    def damping(self) -> Array:
        """Kelvin-Voigt damping of every joint, N m s/rad, shape (N,)."""
        return self.relaxation_time * self.stiffness

    @cached_property
    def pressure_gain(self) -> Array:
        """Joint torque per pressure (the chamber law), A(s_i) e(s_i), N m/Pa, shape (N,)."""
        s = self.joint_arc_lengths
        return self.interpolate("chamber_area", s) * self.interpolate("chamber_eccentricity", s)

    @cached_property
    def link_ends(self) -> Array:
        """Arc lengths where the N + 1 rigid links begin and end, m, shape (N + 2,): base, joints, tip."""
        return np.concatenate([[0.0], self.joint_arc_lengths, [self.length]])

    @cached_property
    def link_masses(self) -> Array:
        """Mass of every link from the base to the tip, kg, shape (N + 1,)."""
        ends = self.link_ends
        middle = (ends[:-1] + ends[1:]) / 2
        section = self.interpolate("width", middle) * self.interpolate("thickness", middle)
        return self.interpolate("density", middle) * section * np.diff(ends)

    @cached_property
    def mass_moments(self) -> Array:
        """First moment of mass, kg m, by which the direction of link j + 1 weighs on joint i, [j, i], (N, N)."""
        lengths, masses = np.diff(self.link_ends)[1:], self.link_masses[1:]
        beyond = np.cumsum(masses[::-1])[::-1] - masses
        return np.tril(np.outer(lengths * (masses / 2 + beyond), np.ones(self.segments)))

    def section_ends(self, sections: int) -> NDArray[np.int_]:
        """Segments covered up to the end of each sensor section, shape (sections + 1,), from 0 to N.

        Sections hold whole segments and are as equal as that allows, so each joint belongs to one section.

        Raises:
            InputError: if there are fewer than 1 or more sections than segments.
        """
        if not 1 <= sections <= self.segments:
            self._reject("sections", sections, f"give 1 to {self.segments} (the number of segments)")
        return np.round(np.arange(sections + 1) * self.segments / sections).astype(int)

    def mass_matrix(self) -> Array:
        """Joint-space mass matrix of the straight finger, kg m^2, shape (N, N)."""
        ends, joints, mass = self.link_ends, self.joint_arc_lengths, self.link_masses
        middle = (ends[:-1] + ends[1:]) / 2
        thickness = self.interpolate("thickness", middle)
        rotational = mass * (np.diff(ends) ** 2 + thickness**2) / 12
        moved = middle[:, None] > joints[None, :]
        lever = np.where(moved, middle[:, None] - joints[None, :], 0.0)
        return lever.T @ (mass[:, None] * lever) + moved.T @ (rotational[:, None] * moved)

    def stable_time_step(self) -> float:
        """Largest step, s, at which explicit springs with implicit joint damping stay stable.

        Drake's discrete plant takes springs, and elastic laws, explicitly and joint damping implicitly. A
        motion that turns round at every step has then just reached the limit: dt^2 K - 2 dt D - 4 M is
        singular. Where the damping is beta times the stiffness, a mode of natural frequency w comes there at
        dt = beta + sqrt(beta^2 + 4 / w^2).
        """
        stiffness, damping = np.diag(self.joint_law.slopes.max(axis=-1)), np.diag(self.damping)
        zero, one = np.zeros_like(damping), np.eye(self.segments)
        inverse_mass = np.linalg.inv(self.mass_matrix())
        # The eigenvalues are the inverses of the steps at which the matrix above is singular.
        steps = np.block([[zero, one], [inverse_mass @ stiffness / 4, -inverse_mass @ damping / 2]])
        return 1 / float(np.linalg.eigvals(steps).real.max())
