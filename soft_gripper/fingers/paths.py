"""Paths along a finger, and what drives it along them: chambers, which push, and tendons, which pull.

A path runs at (x(s), y(s)) of the section, straight between its stations, from the first of them to the last. Per
length of the axis it is as long as

    lambda = | (x' - tau y,  y' + tau x,  1 + epsilon - kappa_y x + kappa_x y) | ,

where kappa_y is the curvature in the plane (positive closes), kappa_x that sideways, tau the twist, epsilon the stretch
and x is counted from the neutral axis: the change of a place of the section per length, seen from the section. The
chain sums it over its segments, with the strain of a segment that of its joints over its length, so that

    l(q) = sum over the segments of  ds lambda(q / ds) .

By virtual work, a tendon of tension T drives the joints with  -T dl/dq , and a chamber of area A under the pressure p
with  p dV/dq = p sum of A dl/dq . A path that runs parallel to the axis has, without twist, a constant gradient: the
chamber law  p A e .

Leading axes are free; P paths, N segments.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger_parts import PressureLaw
from soft_gripper.quantity import Violation, quantity, valid

SIZES = (1e-9, 1e12)
Stations = tuple[float, ...]
Joints = Mapping[str, Array]  # positions, (..., N) rad, or m where they slide, by deformation


@dataclass(frozen=True)
class Path:
    """A line along the finger through points of its section; a single number holds for the whole path."""

    name: str = field(metadata=valid(is_name=True))
    x: Stations = field(metadata=valid("m", sizes=SIZES))  # from the middle of the outer section, toward the inner side
    y: Stations = field(metadata=valid("m", sizes=SIZES))  # across the finger
    at: Stations = quantity((0.0, 1.0), least=0, most=1)  # the stations, as fractions of the length; increasing

    def violations(self) -> Iterator[Violation]:
        if len(self.at) < 2 or not np.all(np.diff(self.at) > 0):
            yield "at", self.at, "must be two increasing fractions of the length or more, such as 0 0.5"
        for column in [part.name for part in fields(self) if part.name in ("x", "y", "width", "thickness")]:
            if len(getattr(self, column)) not in (1, len(self.at)):
                expected = f"give one number, or one for each of the {len(self.at)} stations"
                yield column, getattr(self, column), expected

    def value_at(self, column: str, s: Array | float, length: float) -> Array:
        """A number of the path at arc lengths `s`, m, of a finger of `length`; constant beyond its ends."""
        values = getattr(self, column)
        stations = np.array(self.at) * length
        return np.interp(s, stations, values if len(values) > 1 else np.repeat(values, len(stations)))


@dataclass(frozen=True)
class Chamber(Path):
    """A chamber with a separate pressure."""

    width: Stations = quantity((), "m", above=0, sizes=SIZES)  # along y
    thickness: Stations = quantity((), "m", above=0, sizes=SIZES)  # along x
    # The points of its own pressure law, see `PressureLaw`; None: that of the finger
    law_pressure: Stations | None = quantity(None, "Pa")
    law_effective: Stations | None = quantity(None, "Pa")

    def violations(self) -> Iterator[Violation]:
        yield from super().violations()
        if self.law is not None:
            yield from ((f"law_{field}", value, expected) for field, value, expected in self.law.violations())

    @cached_property
    def law(self) -> PressureLaw | None:
        """Pressure law of this chamber alone; None: the finger's law."""
        if self.law_pressure is None and self.law_effective is None:
            return None
        return PressureLaw(self.law_pressure or (), self.law_effective or ())


@dataclass(frozen=True)
class Tendon(Path):
    """A tendon that is fixed at its last station and pulled at its first."""

    stiffness: float = quantity(0.0, "N/m", least=0, sizes=SIZES)  # if commanded in length; of the whole tendon
    friction: float = quantity(0.0, least=0, most=10)  # Coulomb, against its sheath (capstan)
    # Travel over which friction reverses, before the tendon slides (Dahl)
    reversal: float = quantity(2e-4, "m", above=0, sizes=SIZES)
    # If commanded in length: length pulled in before it tightens; negative: pretension
    slack: float = quantity(0.0, "m", sizes=SIZES)


@dataclass(frozen=True, eq=False)
class PathsOnChain:
    """Paths, at the segments of a chain."""

    x: Array  # (P, N) m from the neutral axis
    y: Array  # (P, N) m
    x_slope: Array  # (P, N) change of x per length
    y_slope: Array  # (P, N)
    covered: Array  # (P, N) m of every segment along which the path runs
    segment_length: float  # m

    @cached_property
    def are_parallel(self) -> bool:
        """Whether all paths run parallel to the axis."""
        return not (self.x_slope.any() or self.y_slope.any())

    @cached_property
    def share(self) -> Array:
        """Fraction of every segment along which a path runs, (P, N)."""
        return self.covered / self.segment_length

    @cached_property
    def rest_changes(self) -> Array:
        """Derivatives of the straight paths by length, along x, y and z of the section, (3, P, N)."""
        return np.stack([self.x_slope, self.y_slope, np.ones_like(self.x)])

    @cached_property
    def levers(self) -> dict[str, Array]:
        """Levers by the strain of a segment, 1/m, (3, P, N) m, by deformation."""
        zeros, ones = np.zeros_like(self.x), np.ones_like(self.x)
        axial_levers = {"bending": -self.x, "sideways": self.y, "stretch": ones}
        levers = {deformation: np.stack([zeros, zeros, lever]) for deformation, lever in axial_levers.items()}
        return levers | {"twist": np.stack([-self.y, self.x, zeros])}


def paths_on_chain(paths: Sequence[Path], neutral_axis: Array, segment_length: float) -> PathsOnChain:
    """Positions and slopes of paths on a chain, at the middle of the covered part of each segment, m long.

    `neutral_axis` is x at the ends of the segments from the middle of the outer section, (N + 1,) m; linear between.
    """
    segments = len(neutral_axis) - 1
    ends = np.arange(segments + 1) * segment_length
    length = float(ends[-1])
    columns = []
    for path in paths:
        first, last = path.at[0] * length, path.at[-1] * length
        low, high = np.clip(ends[:-1], first, last), np.clip(ends[1:], first, last)
        lengths = high - low
        axis = np.interp([low, high], ends, neutral_axis)
        x = np.array([path.value_at("x", s, length) for s in (low, high)]) - axis
        y = np.array([path.value_at("y", s, length) for s in (low, high)])
        distance = np.where(lengths > 0, lengths, 1.0)
        slopes = np.diff([x, y], axis=1)[:, 0] / distance
        slopes[np.abs(slopes) < 1e-12] = 0.0  # rounding
        columns.append((x.mean(axis=0), y.mean(axis=0), *slopes, lengths))
    x, y, x_slope, y_slope, lengths = np.array(columns).reshape(len(paths), 5, segments).swapaxes(0, 1)
    return PathsOnChain(x, y, x_slope, y_slope, lengths, segment_length)


def lengths_and_gradients(paths: PathsOnChain, levers: Array, q: Array) -> tuple[Array, Array]:
    """Lengths of paths on every segment, (..., P, N) m, and dl/dq, (..., P, W, N) m/rad, or 1 where joints slide.

    `levers` are those of `paths.levers` for W deformations, (3, P, W, N), and `q` the joint positions, (..., W, N).
    """
    changes = paths.rest_changes + np.einsum("apwn,...wn->...apn", levers, q / paths.segment_length)
    stretched = _norm(changes)
    axial_changes = changes * (paths.share / stretched)[..., None, :, :]
    return paths.covered * stretched, np.einsum("apwn,...apn->...pwn", levers, axial_changes)


def _norm(changes: Array) -> Array:
    return np.sqrt((changes**2).sum(axis=-3))


def _changes(paths: PathsOnChain, q: Joints) -> Array:
    """Derivatives of paths by length, along x, y and z of the section, (..., 3, P, N)."""
    bend_changes = (angle[..., None, None, :] * paths.levers[name] for name, angle in q.items() if name in paths.levers)
    return paths.rest_changes + sum(bend_changes, np.zeros(1)) / paths.segment_length


def lengths_on_segments(paths: PathsOnChain, q: Joints) -> Array:
    """Lengths of paths on every segment, (..., P, N) m, at joint positions `q`."""
    return np.asarray(paths.covered * _norm(_changes(paths, q)))


def path_lengths(paths: PathsOnChain, q: Joints) -> Array:
    """Lengths of paths, (..., P) m, at joint positions `q`."""
    return np.asarray(lengths_on_segments(paths, q).sum(axis=-1))


def length_gradients(paths: PathsOnChain, q: Joints) -> dict[str, Array]:
    """Derivatives dl/dq, m/rad, or 1 where joints slide, by deformation: (..., P, N), or (P, N) if constant."""
    if paths.are_parallel and "twist" not in q:
        return {deformation: paths.share * paths.levers[deformation][2] for deformation in q}
    changes = _changes(paths, q)
    axial_changes = changes * (paths.share / _norm(changes))[..., None, :, :]
    return {deformation: np.asarray((axial_changes * paths.levers[deformation]).sum(axis=-3)) for deformation in q}
