"""A soft finger as physical parameters, and the chain of rigid segments that models it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.files.document import check_config
from soft_gripper.fingers.cross_section import SIZES, CrossSection, Hole, PiercedSection, Station
from soft_gripper.fingers.finger_parts import (
    AXES,
    SLIDES,
    YIELDS,
    ContactMaterial,
    CreepBranch,
    ElasticLaw,
    LinkInertias,
    PressureLaw,
    TipLoad,
    joint_order,
)
from soft_gripper.fingers.paths import Chamber, Path, PathsOnChain, Tendon, length_gradients, paths_on_chain
from soft_gripper.piecewise_linear import PiecewiseLinear
from soft_gripper.quantity import Violation, quantity, valid

_LENGTH_TOLERANCE = 1e-9  # m
_MAX_SEGMENTS = 500
_MAX_THICKNESS = 1000  # lengths of a segment; joints are drawn with as many cylinders
_STEP_TOLERANCE = 1e-9  # fraction of the length within which a position is at a step
_MIN_SECTION_SPACING = 1e-6  # fraction of the length, minimum distance of sections that are not a step


@dataclass(frozen=True)
class Finger:
    """A finger of `length` m in `segments` equal segments, a joint in the middle of each.

    Joints in the middles are the midpoint rule: the chain converges to the beam with the square of the
    segment length, and every joint belongs to exactly one sensor section. Frame B sits at the base on the neutral
    axis, which keeps its length and is the axis of the chain, with +z along the straight finger and +x toward the
    object; a positive joint angle closes the finger.

    Raises:
        InputError: if a field is not finite or out of range, or a section cannot be moulded.
    """

    name: str = field(metadata=valid(is_name=True))
    length: float = field(metadata=valid("m", above=0, sizes=SIZES))
    base: CrossSection
    tip: CrossSection
    sensor_spacing: float = field(metadata=valid("m", above=0, sizes=SIZES))  # of inner and outer sensor path (Delta_R)
    segments: int = quantity(12, least=1, most=_MAX_SEGMENTS)
    relaxation_time: float = quantity(0.015, "s", least=0, sizes=SIZES)  # Kelvin-Voigt: damping over stiffness
    contact: ContactMaterial = field(default_factory=ContactMaterial)
    elastic_law: ElasticLaw | None = None  # instead of E I times curvature
    creep: tuple[CreepBranch, ...] = ()  # decay of the instantaneous stiffness
    pressure_law: PressureLaw | None = None  # None: the pressure itself
    # Shear correction factor kappa (Timoshenko); 0: rigid in shear.
    shear_factor: float = quantity(0.0, least=0, sizes=SIZES)
    tip_load: TipLoad | None = None
    yields: tuple[str, ...] = quantity(("bending",), known=YIELDS)  # deformations in which it is not rigid
    chambers: tuple[Chamber, ...] = ()  # none: the chamber of its sections, if these have one
    tendons: tuple[Tendon, ...] = ()
    sections: tuple[Station, ...] = ()  # between base and tip, in this order; two at one place are a step
    pressure_offset: float = quantity(0.0, "Pa")  # of a nominal finger: excess of its pressure readings

    def __post_init__(self) -> None:
        check_config(f"finger '{self.name}'", self)

    @property
    def unnamed(self) -> tuple[Any, ...]:
        """Key for a cache: equal for fingers that differ by nothing but their names."""
        return tuple(getattr(self, parameter.name) for parameter in fields(self) if parameter.name != "name")

    def violations(self) -> Iterator[Violation]:
        """Yields violations of rules across fields: sensor paths, creep that leaves some stiffness, deformations."""
        yield from self._misplaced_sections()
        thickness = max(float(section.thickness) for section in self.cross_sections)
        if thickness * self.segments > _MAX_THICKNESS * self.length:
            expected = f"a section {thickness:g} m thick needs segments of at least {thickness / _MAX_THICKNESS:g} m"
            yield "segments", self.segments, expected
        inner, outer = self.sensor_offsets
        for place, section in zip(self.places, self.cross_sections, strict=True):
            excess = max(inner - float(section.inner_face), float(section.outer_face) - outer)
            if excess > _LENGTH_TOLERANCE:
                location = {0.0: "its base", 1.0: "its tip"}.get(place, f"{place:g} of its length")
                expected = f"a sensor path would lie {1e3 * excess:.2g} mm outside the finger at {location}; give less"
                yield "sensor_spacing", self.sensor_spacing, expected
        shares = [branch.share for branch in self.creep]
        if sum(shares) >= 1:
            yield "creep.share", shares, "must be less than 1 in all, or nothing would be left of the stiffness"
        if np.any(self.joint_law.slopes <= sum(shares) * self.stiffness[:, None]):
            expected = "the creep exceeds the smallest slope of the elastic law: give smaller shares"
            yield "creep.share", shares, expected
        if self.takes_stiffness and (self.elastic_law or self.pressures != 1 or self.yields != ("bending",)):
            expected = "leave it out: only a linear finger that bends in its plane alone, by one pressure, has it"
            yield "pressure_law.stiffness_taken", self.pressure_law and self.pressure_law.stiffness_taken, expected
        yield from self._rigid_violations()
        yield from self._path_violations()

    def _misplaced_sections(self) -> Iterator[Violation]:
        for i, (previous, position) in enumerate(pairwise(self.places[:-1])):
            if position < previous or 0 < position - previous < _MIN_SECTION_SPACING:
                spacing = f"{_MIN_SECTION_SPACING:g} apart or at one place"
                expected = f"give sections in order, {spacing}; the one before is at {previous:g}"
                yield f"sections[{i}].at", position, expected
            if self.places[: i + 2].count(position) > 2:
                yield f"sections[{i}].at", position, "give one section at a place, or two for a step"

    def _rigid_violations(self) -> Iterator[Violation]:
        """Yields violations by the deformations, and by the parameters that these need."""
        layers = [section for section in self.cross_sections if section.layer_thickness > 0]
        yields, moduli = " ".join(self.yields), [float(layer.layer_shear_modulus) for layer in layers]
        if "bending" not in self.yields or len(set(self.yields)) < len(self.yields):
            yield "yields", yields, "must name bending, and no way twice"
        if "sideways" in self.yields and "twist" not in self.yields:
            yield "yields", yields, "add twist, by which a bent finger yields sideways up to twenty times as far"
        if self.shear_factor > 0 and len(self.yields) > 1:
            yield "shear_factor", self.shear_factor, "leave it out: only a finger that yields in bending alone shears"
        if moduli and min(moduli) == 0 < max(moduli):
            expected = "give it in every section with a layer, or in none: between them it is interpolated"
            yield "layer_shear_modulus", max(moduli), expected

    def _path_violations(self) -> Iterator[Violation]:
        """Yields violations by chambers and tendons: names, points off the section, overlaps, missing mirrors."""
        names = [path.name for path in (*self.chambers, *self.tendons)]
        for path in (*self.chambers, *self.tendons):
            kind = "chamber" if isinstance(path, Chamber) else "tendon"
            if names.count(path.name) > 1:
                yield f"{kind}.name", path.name, "appears more than once"
            yield from ((f"{kind}.{field}", value, expected) for field, value, expected in self.path_violations(path))
        if self.chambers and max(float(section.chamber_area) for section in self.cross_sections) > 0:
            yield "chamber", names[0], "leave out chamber_width and chamber_thickness of the sections, or <chamber>"
        if self.creep and any(self.laws) and (len(self.chambers) > 1 or any(chamber.law for chamber in self.chambers)):
            yield "creep", self.creep, "only a finger with one chamber, and a pressure law of its own, creeps with one"
        if self.shear_factor > 0 and names:
            yield "shear_factor", self.shear_factor, "leave it out: a finger with chambers or tendons does not shear"
        for s in {s for chamber in self.chambers for s in self._stations(chamber)}:
            holes = self._holes(s)
            off_plane = [hole for hole in holes if float(hole.area) > 0 and abs(float(hole.y)) > _LENGTH_TOLERANCE]
            mirrored = [np.array(hole) * [1, 1, 1, -1] for hole in off_plane]
            if not all(
                any(np.allclose(np.array(hole), m, 0, _LENGTH_TOLERANCE) for m in mirrored) for hole in off_plane
            ):
                yield "chamber.y", [float(hole.y) for hole in holes], "give a chamber at -y for each at y, and as wide"
            if any(_overlap(one, other) for i, one in enumerate(holes) for other in holes[:i]):
                yield "chamber.x", [float(hole.x) for hole in holes], f"chambers overlap at {1e3 * s:.3g} mm"

    def path_violations(self, path: Path) -> Iterator[Violation]:
        """Yields the first violation, by field, where a path or the chamber along it leaves the section."""
        for s in self._stations(path):
            section = self.section(s)
            x, y = (float(path.value_at(name, s, self.length)) for name in "xy")
            t = w = 0.0
            half = room = float(section.thickness) / 2
            if isinstance(path, Chamber):
                t, w = (float(path.value_at(name, s, self.length)) / 2 for name in ("thickness", "width"))
                room = half - float(section.layer_thickness)
            if not (x + t <= room + _LENGTH_TOLERANCE and t - x <= half + _LENGTH_TOLERANCE):
                expected = f"leaves the section at {1e3 * s:.3g} mm, where x runs from {-half:.3g} to {room:.3g} m"
                yield "x", path.x, expected
                return
            if abs(y) + w > float(section.width) / 2 + _LENGTH_TOLERANCE:
                expected = f"leaves the section at {1e3 * s:.3g} mm, which is {float(section.width):.3g} m wide"
                yield "y", path.y, expected
                return

    def _stations(self, path: Path) -> list[float]:
        return [share * self.length for share in path.at]

    @property
    def segment_length(self) -> float:
        return self.length / self.segments

    @cached_property
    def joint_arc_lengths(self) -> Array:
        """Arc length s of every joint from the base, m, shape (N,)."""
        return (np.arange(self.segments) + 0.5) * self.segment_length

    @property
    def cross_sections(self) -> tuple[CrossSection, ...]:
        """Given cross-sections, base to tip."""
        return (self.base, *self.sections, self.tip)

    @property
    def places(self) -> tuple[float, ...]:
        """Positions of the cross-sections, as fractions of the length, from 0 to 1."""
        return (0.0, *(section.at for section in self.sections), 1.0)

    def with_sections(self, change: Callable[[Any], Any], **others: Any) -> "Finger":
        """The finger with a change of every cross-section that is given, and with `others` of its fields."""
        base, *between, tip = map(change, self.cross_sections)
        return replace(self, base=base, sections=tuple(between), tip=tip, **others)

    def section(self, s: Array | float) -> CrossSection:
        """The cross-section at arc lengths `s` (m), with linearly interpolated parameters.

        At a step it is the one beyond.
        """
        position = np.asarray(s) / self.length
        places, parameters = self._section_parameters
        piece = np.clip(np.searchsorted(places, position + _STEP_TOLERANCE) - 1, 0, len(places) - 2)
        fraction = (position - places[piece]) / (places[piece + 1] - places[piece])
        numbers = {name: at[piece] + (at[piece + 1] - at[piece]) * fraction for name, at in parameters.items()}
        return PiercedSection(**numbers, bores=self._holes(s)) if self.chambers else CrossSection(**numbers)

    @cached_property
    def _section_parameters(self) -> tuple[Array, dict[str, Any]]:
        """Positions of the cross-sections, as fractions of the length, and the values of each parameter there."""
        names = [part.name for part in fields(CrossSection)]
        section_values = {name: np.array([getattr(section, name) for section in self.cross_sections]) for name in names}
        return np.array(self.places), section_values

    def _holes(self, s: Array | float) -> tuple[Hole, ...]:
        """The chambers at arc lengths `s`, m."""
        s = np.asarray(s)
        holes = []
        for chamber in self.chambers:
            first, last = (self.length * end for end in (chamber.at[0], chamber.at[-1]))
            mask = (s > first - _LENGTH_TOLERANCE) & (s < last + _LENGTH_TOLERANCE)
            numbers = {name: chamber.value_at(name, s, self.length) for name in ("width", "thickness", "x", "y")}
            holes.append(Hole(mask * numbers["width"], mask * numbers["thickness"], numbers["x"], numbers["y"]))
        return tuple(holes)

    def on_chain(self, paths: Sequence[Path]) -> PathsOnChain:
        """Paths of this finger, at the segments of its chain."""
        ends = np.arange(self.segments + 1) * self.segment_length
        return paths_on_chain(paths, np.asarray(self.section(ends).neutral_axis), self.segment_length)

    @cached_property
    def _joint_sections(self) -> CrossSection:
        return self.section(self.joint_arc_lengths)

    @property
    def thinnest(self) -> CrossSection:
        """Thinnest of the specified cross-sections."""
        return min(self.cross_sections, key=lambda section: section.thickness)

    @cached_property
    def sensor_offsets(self) -> tuple[float, float]:
        """Distances of the inner and the outer sensor path from the neutral axis, m, positive on the inner side.

        The paths run parallel to the axis and lie symmetrically in the finger where it is thinnest.
        """
        middle = -float(self.thinnest.neutral_axis)
        return middle + self.sensor_spacing / 2, middle - self.sensor_spacing / 2

    def deformations(self, segment: int) -> tuple[str, ...]:
        """Deformations of the joints in the middle of a segment, from the base to the tip."""
        return ("shear", "bending") if self.shear_factor > 0 else joint_order(self.yields, segment)

    @property
    def driven_deformations(self) -> tuple[str, ...]:
        """Ways of yielding that pressures and tendons drive: a chamber of the sections bends and stretches."""
        return self.yields if self.chambers or self.tendons else tuple({"bending", "stretch"} & {*self.yields})

    @cached_property
    def stiffness(self) -> Array:
        """Bending stiffness of every joint, k_i = E I(s_i) / ds, N m/rad, shape (N,)."""
        return np.asarray(self._joint_sections.bending_stiffness) / self.segment_length

    @cached_property
    def shear_stiffness(self) -> Array:
        """Stiffness of every joint across its link, kappa G A(s_i) / ds, N/m, (N,); G = E / 3 of rubber."""
        section = self._joint_sections
        return np.asarray(self.shear_factor * section.youngs_modulus / 3 * section.area) / self.segment_length

    @cached_property
    def stiffnesses(self) -> dict[str, Array]:
        """Stiffness of every joint by deformation, N m/rad, and N/m where it slides, (N,) each."""
        stiffnesses = {"bending": self.stiffness, "shear": self.shear_stiffness}
        for name in set(self.yields) - {"bending"}:
            stiffnesses[name] = np.asarray(getattr(self._joint_sections, f"{name}_stiffness")) / self.segment_length
        return {name: stiffnesses[name] for name in self.deformations(0)}

    def elastic_torque(self, q: Array) -> Array:
        """Elastic restoring torque at joint angles (..., N) rad, N m, (..., N)."""
        return self.stiffness * q if self.elastic_law is None else self.joint_law(q)

    def angle(self, torque: Array, pressure: Array | float = 0.0) -> Array:
        """Joint angles, rad, where the elastic torque that a pressure, (...) Pa, leaves is `torque`, (..., N) N m."""
        if self.elastic_law is not None:
            return self.joint_law.inverse()(torque)
        return torque / (self.stiffness * (1 - self.share_taken(pressure)[..., None]))

    @cached_property
    def joint_law(self) -> PiecewiseLinear:
        """Torque against angle of every joint: the elastic law, or the straight line of the stiffness."""
        law = self.elastic_law
        if law is None:
            ends = np.outer(np.ones(self.segments), [-1.0, 1.0])
            return PiecewiseLinear(ends, ends * self.stiffness[:, None])
        fractions = (self.joint_arc_lengths / self.length)[:, None]
        torques = (1 - fractions) * np.array(law.base_moment) + fractions * np.array(law.tip_moment)
        angles = np.array(law.curvature) * self.segment_length
        return PiecewiseLinear(np.broadcast_to(angles, torques.shape), torques)

    @cached_property
    def damping(self) -> Array:
        """Kelvin-Voigt damping of every joint, N m s/rad, shape (N,)."""
        return self.relaxation_time * self.stiffness

    @cached_property
    def pressures(self) -> int:
        """Number of supplied pressures: one for each chamber."""
        largest_area = max(float(section.chamber_area) for section in self.cross_sections)
        return len(self.chambers) if self.chambers or (self.tendons and largest_area == 0) else 1

    @cached_property
    def laws(self) -> tuple[PressureLaw | None, ...]:
        """Pressure law of each pressure, from its chamber or the finger; None: neither has one."""
        chamber_laws = [chamber.law for chamber in self.chambers] or [None] * self.pressures
        return tuple(law or self.pressure_law for law in chamber_laws)

    @property
    def chamber_axis(self) -> dict[str, list[str]]:
        """Labels of the pressures in a signal, if there are several."""
        names = [chamber.name for chamber in self.chambers]
        return {"chamber": names} if len(names) > 1 else {}

    @property
    def tendon_axis(self) -> dict[str, list[str]]:
        """Labels of the tendons in a signal, if there are several."""
        names = [tendon.name for tendon in self.tendons]
        return {"tendon": names} if len(names) > 1 else {}

    @cached_property
    def pressure_gains(self) -> dict[str, Array]:
        """Torque of every chamber per pressure at every joint of the straight finger, by deformation.

        (C, N) each, N m/Pa, and N/Pa where joints slide: the chamber law p A(s_i) e(s_i), and p A(s_i).
        """
        if len(self.chambers) == self.pressures:
            return self.chamber_gains({deformation: np.zeros(self.segments) for deformation in self.yields})
        section = self._joint_sections
        area = np.asarray(section.chamber_area)
        gains = {"bending": area * section.chamber_eccentricity, "stretch": area}
        return {deformation: gains.get(deformation, 0 * area)[None, :] for deformation in self.yields}

    def chamber_gains(self, q: Mapping[str, Array]) -> dict[str, Array]:
        """Gains of the listed chambers at joint positions `q`, (..., C, N).

        `q` has the positions of the joints, (..., N) rad, or m, by deformation.
        """
        return {name: self._chamber_areas * slope for name, slope in length_gradients(self.chamber_paths, q).items()}

    @cached_property
    def _chamber_areas(self) -> Array:
        """Areas of the listed chambers at every joint, m^2, (C, N)."""
        return np.reshape([hole.area for hole in self._holes(self.joint_arc_lengths)], (-1, self.segments))

    @cached_property
    def tension_gains(self) -> dict[str, Array]:
        """Torque of every tendon per tension at every joint of the straight finger, by deformation, (T, N) m."""
        straight = {deformation: np.zeros(self.segments) for deformation in self.yields}
        return {deformation: -g for deformation, g in length_gradients(self.tendon_paths, straight).items()}

    @cached_property
    def chamber_paths(self) -> PathsOnChain:
        """Paths of the listed chambers."""
        return self.on_chain(self.chambers)

    @cached_property
    def tendon_paths(self) -> PathsOnChain:
        """Paths of the tendons."""
        return self.on_chain(self.tendons)

    @cached_property
    def pressure_gain(self) -> Array:
        """Bending torque per pressure, N m/Pa, (N,); of several chambers the root of the squares.

        A finger without a chamber has the gain of one in the outer half of the section, a quarter of its area; it
        scales the assumptions of estimators.
        """
        if self.pressures:
            return np.asarray(np.hypot.reduce(self.pressure_gains["bending"], axis=0))
        section = self._joint_sections
        return np.asarray(section.area * section.thickness / 16)

    def pressure_torque(self, pressure: Array | float) -> Array:
        """Torque of the pressure of a single chamber on the joints, (...) Pa -> (..., N) N m, positive closes.

        Raises:
            InputError: if the finger has several chambers, or only tendons.
        """
        if self.pressures != 1:
            expected = "this is for fingers with one chamber"
            raise InputError(f"finger '{self.name}'", "chambers", self.pressures, expected)
        return self.torque_of_drive("bending", np.asarray(pressure)[..., None])

    def torque_of_drive(self, deformation: str, pressures: Array, tensions: Array | None = None) -> Array:
        """Torque of the drive of the straight finger, at the joints of one deformation, (..., N) N m, or N.

        Args:
            deformation: one of those of the finger.
            pressures: in the chambers, (..., C) Pa.
            tensions: of the tendons, (..., T) N; None: there are none.
        """
        effective = self.effective_pressure(pressures)
        torque = effective @ self.pressure_gains[deformation]
        return torque if tensions is None else torque + tensions @ self.tension_gains[deformation]

    def effective_pressure(self, pressures: Array) -> Array:
        """Pressure that gives the torque by the chamber law, of every chamber, (..., C) Pa -> (..., C) Pa."""
        if self.pressure_offset:
            pressures = pressures - self.pressure_offset
        if not any(self.laws):
            return pressures
        laws_and_pressures = zip(self.laws, np.moveaxis(pressures, -1, 0), strict=True)
        return np.stack([p if law is None else law.softening(p) * p for law, p in laws_and_pressures], axis=-1)

    def softening(self, pressure: Array | float) -> Array:
        """Ratio of the torque to that without a pressure law, at pressures (...) Pa, (...)."""
        if self.pressure_law is None:
            return np.ones(np.shape(pressure))
        return self.pressure_law.softening(pressure - self.pressure_offset)

    @property
    def takes_stiffness(self) -> bool:
        """Whether pressure takes a part of the bending stiffness."""
        return self.pressure_law is not None and bool(self.pressure_law.stiffness_taken)

    def share_taken(self, pressure: Array | float) -> Array:
        """Fraction of the bending stiffness that pressures (...) Pa take, (...)."""
        if self.pressure_law is None:
            return np.zeros(np.shape(pressure))
        return self.pressure_law.share_taken(np.asarray(pressure) - self.pressure_offset)

    @cached_property
    def link_ends(self) -> Array:
        """Arc lengths where the N + 1 rigid links begin and end, m, shape (N + 2,): base, joints, tip."""
        return np.concatenate([[0.0], self.joint_arc_lengths, [self.length]])

    @cached_property
    def links(self) -> LinkInertias:
        """Inertias of the N + 1 rigid links from the base to the tip, the load at the tip included."""
        middles = (self.link_ends[:-1] + self.link_ends[1:]) / 2
        lengths = np.diff(self.link_ends)
        load = self.tip_load
        section = self.section(middles)
        mass = np.asarray(section.density * section.area * lengths)
        center = np.array([section.mass_center, lengths / 2])
        bare_links = LinkInertias(mass, center, np.array([*section.gyration, lengths**2 / 12]), np.zeros(lengths.shape))
        return bare_links if load is None else bare_links.with_load(load.mass, np.array([load.x, lengths[-1] + load.z]))

    @property
    def link_masses(self) -> Array:
        """Mass of every link from the base to the tip, kg, shape (N + 1,)."""
        return self.links.mass

    @property
    def link_centers(self) -> Planar:
        """Centre of mass of every link, m from its proximal end, z + i x, shape (N + 1,)."""
        x, z = self.links.center
        return z + 1j * x

    @property
    def link_gyration(self) -> Array:
        """Squares of the radii of gyration of the links about their centres along x, y and z, m^2, (3, N + 1)."""
        return self.links.gyration

    @cached_property
    def mass_moments(self) -> Planar:
        """First moment of mass, kg m, of the direction of link j + 1 about joint i, [j, i], (N, N)."""
        lengths, masses = np.diff(self.link_ends)[1:], self.link_masses[1:]
        outer_masses = np.cumsum(masses[::-1])[::-1] - masses
        moments = lengths * outer_masses + masses * self.link_centers[1:]
        return np.tril(np.outer(moments, np.ones(self.segments)))

    def section_ends(self, sections: int) -> NDArray[np.int_]:
        """Segments covered up to the end of each sensor section, shape (sections + 1,), from 0 to N.

        Sections hold whole segments and are as equal as that allows, so each joint belongs to one section.

        Raises:
            InputError: if there are fewer than 1 or more sections than segments.
        """
        if not isinstance(sections, int | np.integer) or not 1 <= sections <= self.segments:
            expected = f"must be 1 to {self.segments}, the number of segments"
            raise InputError(f"finger '{self.name}'", "sections", sections, expected)
        return np.round(np.arange(sections + 1) * self.segments / sections).astype(int)

    def mass_matrix(self, deformations: Sequence[str] = ("bending",)) -> Array:
        """Joint-space mass matrix of the straight finger, shape (W N, W N).

        Joints of one deformation are followed by those of the next; kg m^2 where both turn, kg where both slide.
        """
        links, joints = self.links, self.joint_arc_lengths
        x, z = links.center
        is_moved = (self.link_ends[:-1, None] >= joints)[..., None]
        heights = (self.link_ends[:-1] + z)[:, None] - joints
        # From each joint to the links' centres.
        levers = np.stack([x[:, None] + 0 * heights, 0 * heights, heights], axis=-1)
        rotations = [is_moved * (np.array(AXES[name]) * (name not in SLIDES) + 0 * levers) for name in deformations]
        translations = [
            is_moved * (AXES[name] + 0 * levers) if name in SLIDES else np.cross(rate, levers)
            for name, rate in zip(deformations, rotations, strict=True)
        ]
        v, w = (np.concatenate(rates, axis=1) for rates in (translations, rotations))  # (L, W N, 3)
        link_matrices: Array = v @ (links.mass[:, None, None] * v.swapaxes(1, 2)) + w @ links.tensors @ w.swapaxes(1, 2)
        return link_matrices.sum(axis=0)

    def stable_time_step(self, implicit: bool = False) -> float:
        """Largest step, s, at which explicit springs with implicit joint damping stay stable.

        Drake's discrete plant takes springs, and elastic laws, explicitly and joint damping implicitly; with `implicit`
        springs, only the tendons are explicit. A motion that reverses at every step is at the limit:
        dt^2 (K_explicit - K_implicit) - 2 dt D - 4 M is singular. Where the damping is beta times the stiffness, a mode
        of natural frequency w reaches it at dt = beta + sqrt(beta^2 + 4 / w^2). Infinite if no step is too long.
        """
        max_stiffening = 1.0 if self.pressure_law is None else 1 - min(self.pressure_law.taken_fraction.y)
        max_stiffnesses = self.stiffnesses | {"bending": max_stiffening * self.joint_law.slopes.max(axis=-1)}
        joints = np.diag(np.concatenate(list(max_stiffnesses.values())))
        damping = self.relaxation_time * np.diag(np.concatenate(list(self.stiffnesses.values())))
        # The stiffness that the tendons add at the joints of the straight finger, (W N, W N).
        zeros = np.zeros((len(self.tendons), self.segments))
        levers = np.concatenate([self.tension_gains.get(name, zeros) for name in max_stiffnesses], axis=-1)
        tendons = (levers.T * [tendon.stiffness for tendon in self.tendons]) @ levers
        stiffness = tendons + (-joints if implicit else joints)
        identity = np.eye(len(joints))
        inverse_mass = np.linalg.inv(self.mass_matrix(list(max_stiffnesses)))
        # The eigenvalues are the inverses of the steps at which the matrix above is singular.
        steps = np.block([[0 * identity, identity], [inverse_mass @ stiffness / 4, -inverse_mass @ damping / 2]])
        longest = float(np.linalg.eigvals(steps).real.max())
        return 1 / longest if longest > 0 else np.inf


def _overlap(first: Hole, second: Hole) -> bool:
    (width, thickness, *_), (wide, thick, *_) = np.array(first, float), np.array(second, float)
    x, y = (np.array(first, float) - np.array(second, float))[2:]
    room = min((width + wide) / 2 - abs(y), (thickness + thick) / 2 - abs(x))
    return bool(min(width * thickness, wide * thick) > 0 and room > _LENGTH_TOLERANCE)
