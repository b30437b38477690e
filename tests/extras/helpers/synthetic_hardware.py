"""Recordings of made-up hardware whose truth is known: a beam, a pneumatic segment, an arm, as files with noise.

Nothing here knows the project: rods are continua (Ritz functions, Gauss quadrature, the implicit midpoint rule) and
not chains, arcs are closed forms, and columns, units and axes are written as in the published data sets. Lengths are
in m and pressures in Pa, unless a name says otherwise; planar vectors are z + i x, z along the straight body.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.linalg import block_diag

Array = np.ndarray
G = 9.81  # m/s^2
MARKER_NOISE = 2e-5  # m, standard deviation
_STEP = 2e-3  # s, in which rods move
_NODES, _OF_NODES = np.polynomial.legendre.leggauss(6)
_X, _WEIGHTS = (1 + _NODES) / 2, _OF_NODES / 2  # along the rod, from 0 to 1
_POWERS = np.arange(6)
_INTEGRAL = (np.append(_X, 1.0)[:, None] ** (_POWERS + 1) / (_POWERS + 1)) @ np.linalg.inv(_X[:, None] ** _POWERS)


@dataclass(frozen=True)
class Rod:
    """A clamped elastic rod that creeps; its heading is a x + b x^2 + c x^3 along itself, its shear d + e x."""

    length: float
    bending: float  # E I, N m^2, instantaneous
    shear: float  # kappa G A, N; inf: rigid
    mass: float  # kg/m
    rotary: float  # kg m, density times second moment of area
    relaxation_time: float  # s, of Kelvin and Voigt
    creep: tuple[tuple[float, float], ...]  # share and time, s
    load: float = 0.0  # kg, a point
    load_place: complex = 0.0  # from the tip, in its frame
    string: float = 0.0  # on which the load hangs toward +x, and swings; 0: it is fixed

    @cached_property
    def bends(self) -> Array:
        """Heading at the places of quadrature and at the tip by a, b, c."""
        return np.append(_X, 1.0)[:, None] ** np.array([1, 2, 3])

    @cached_property
    def shears(self) -> Array:
        return np.append(_X, 1.0)[:, None] ** np.arange(0 if np.isinf(self.shear) else 2)

    @cached_property
    def masses(self) -> Array:
        return np.append(self.mass * self.length * _WEIGHTS, self.load)

    @cached_property
    def stiffness(self) -> Array:
        slopes = np.array([1, 2, 3]) * _X[:, None] ** np.array([0, 1, 2])
        of_bend = self.bending / self.length * (slopes.T * _WEIGHTS) @ slopes
        of_shear = np.zeros((0, 0))
        if np.isfinite(self.shear):
            of_shear = self.shear * self.length * (self.shears[:-1].T * _WEIGHTS) @ self.shears[:-1]
        return block_diag(of_bend, of_shear, *([[0.0]] if self.string else []))

    def _shear(self, u: Array) -> Array:
        return self.shears @ u[3 : 3 + self.shears.shape[1]]

    def _integrated(self, values: Array) -> Array:
        """From the base to the places of quadrature and to the tip."""
        return self.length * (_INTEGRAL @ values[:-1])

    def _terms(self, u: Array, v: Array) -> tuple[Array, Array, Array]:
        """Derivatives of the places of the masses by u, their accelerations without those of u, the mass matrix."""
        heading, slope = np.exp(1j * self.bends @ u[:3]), 1 + 1j * self._shear(u)
        turns, slides = self.bends @ v[:3], self._shear(v)
        columns = [1j * self.bends * (heading * slope)[:, None], 1j * self.shears * heading[:, None]]
        bias = heading * (-(turns**2) * slope - 2 * turns * slides)
        parts = self._integrated(np.column_stack([*columns, bias]))
        parts[-1, :3] += 1j * self.load_place * heading[-1] * self.bends[-1]
        parts[-1, -1] -= self.load_place * heading[-1] * turns[-1] ** 2
        if self.string:
            hangs, swing = 1j * self.string * np.exp(1j * u[-1]), np.zeros((len(parts), 1), dtype=complex)
            parts[-1, -1] -= hangs * v[-1] ** 2
            swing[-1] = 1j * hangs
            parts = np.hstack([parts[:, :-1], swing, parts[:, -1:]])
        J = parts[:, :-1]
        mass = (J.conj().T * self.masses @ J).real
        mass[:3, :3] += self.rotary * self.length * (self.bends[:-1].T * _WEIGHTS) @ self.bends[:-1]
        return J, parts[:, -1], mass

    def tip(self, u: Array) -> tuple[complex, float]:
        along = np.exp(1j * self.bends @ u[:3]) * (1 + 1j * self._shear(u))
        return complex(self._integrated(along)[-1]), float(u[:3].sum())

    def move(
        self, time: Array, gravity: complex, held: Callable, pressure: Callable, moment: Callable, softening: Callable
    ) -> tuple[Array, Array]:
        """Tip and heading at times (T,), s, from 0 on, at rest and straight before; by the implicit midpoint rule.

        Args:
            time: of the results.
            gravity: planar, m/s^2.
            held: share of the weight that a hand bears, by time.
            pressure: in the chamber, by time.
            moment: along the rod, by pressure.
            softening: by which pressure bends further, by pressure, as it takes a part of the stiffness.
        """
        K, n, step = self.stiffness, len(self.stiffness), _STEP
        u, v, before = np.zeros(n), np.zeros(n), np.zeros(n)
        z = np.zeros((len(self.creep), 3))
        weight = _forces(self._terms(u, v)[0], self.masses, gravity)
        shares, lasts = np.array(self.creep).T[..., None]
        times, found = [0.0], [self.tip(u)]
        while times[-1] < time[-1]:
            middle = times[-1] + step / 2
            p, at = pressure(middle), u + step / 2 * v
            J, bias, mass = self._terms(at, 1.5 * v - 0.5 * before)
            remains = softening(0.0) / softening(p)
            forces = _forces(J, self.masses, gravity - bias) - held(middle) * weight
            forces[:3] += remains * moment(p) + K[:3, :3] @ ((shares * z).sum(axis=0) + (1 - remains) * at[:3])
            implicit = step / 2 * (step / 2 + self.relaxation_time) * K
            v, before = np.linalg.solve(mass + implicit, (mass - implicit) @ v + step * (forces - K @ u)), v
            u = u + step / 2 * (v + before)
            z += (1 - np.exp(-step / lasts)) * (u[:3] - z)
            times.append(times[-1] + step)
            found.append(self.tip(u))
        places, headings = (np.array(values) for values in zip(*found, strict=True))
        return np.interp(time, times, places), np.interp(time, times, headings)


def _forces(J: Array, masses: Array, acceleration: Array | complex) -> Array:
    return (J.conj() * (masses * acceleration)[:, None]).real.sum(axis=0)


# ---- the beam


@dataclass(frozen=True)
class BeamTruth:
    """Of a beam of 100 x 30 x 30 mm and 1070 kg/m^3, as the shipped file has it."""

    youngs_modulus: float = 3.1e5
    relaxation_time: float = 4e-3
    creep: tuple[tuple[float, float], ...] = ((0.06, 0.06), (0.14, 1.5))
    released: float = 0.41  # s
    lets_go: float = 0.05  # s


BEAM = BeamTruth()
BEAM_LOADS = {"gravity": 0.0, "load_52g": 0.052, "load_101g": 0.102}  # kg


def beam_motion(truth: BeamTruth, load: float, time: Array, released: float) -> tuple[Array, Array]:
    """Tip and heading of the beam at times of a recording."""
    E, area, inertia = truth.youngs_modulus, 0.03**2, 0.03**4 / 12
    rod = Rod(
        0.1, E * inertia, 0.857 * E / 3 * area, 1070 * area, 1070 * inertia, truth.relaxation_time, truth.creep,
        load, -0.015j, 0.2 if load else 0.0,
    )  # fmt: skip

    def held(t: float) -> float:
        return max(0.0, 1 - t / truth.lets_go)

    return _since(time, released, 0.1, lambda t: rod.move(t, 1j * G, held, lambda t: 0.0, lambda p: 0.0, lambda p: 1.0))


def write_beam(folder: Path, duration: float = 2.0, truth: BeamTruth = BEAM, seed: int = 1) -> Path:
    """Three files of motion capture, 100 Hz, mm: -x is down, z along the beam; each is released at its own time."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(seed)
    for i, (name, load) in enumerate(BEAM_LOADS.items()):
        time = np.arange(0, duration, 0.01)
        place, heading = beam_motion(truth, load, time, truth.released + 0.13 * i)
        axes = np.array([[-1, 0, 0], [0, -1, 0], [0, 0, 1.0]]).T  # columns: x, y, z of the beam
        tips = [(0.013j, 0.004), (0.001 + 0.002j, -0.012), (-0.002 - 0.012j, 0.011)]
        bases = [(0.01j, 0.02), (0.002 - 0.015j, -0.02), (0.001 - 0.01j, 0.021)]
        _write_markers(
            folder / f"{name}.csv", time, (place, heading), tips, bases, [0.0595, 0.0305, -0.025], axes, random
        )
    return folder


# ---- the pneumatic segment


@dataclass(frozen=True)
class SegmentTruth:
    """Of a segment of 25 x 25 mm with a chamber of 12 x 8 mm at 6 mm from its middle."""

    youngs_modulus: float = 2.3e5
    length: float = 0.105  # m
    density: float = 270.0  # kg/m^3, of what is mostly hollow
    relaxation_time: float = 0.014
    creep: tuple[tuple[float, float], ...] = ((0.08, 0.1), (0.15, 1.4))
    law: tuple[float, float] = (0.705, 90e3)  # gain of a small pressure, and Pa at which the chamber balloons
    fill_time: float = 0.09
    swelling: float = 1.0
    mounting: complex = -0.002 + 0.0015j
    opens: float = 0.42
    open_for: float = 2.0

    def gain(self, pressure: float) -> float:
        """Effective pressure per pressure."""
        return float(self.law[0] / (1 - pressure / self.law[1]))


SEGMENT = SegmentTruth()
SEGMENT_PRESSURES = (10, 15, 25, 35, 45)  # kPa


def hollow(side: float, width: float, depth: float, at: float) -> tuple[float, float, float]:
    """Area, m^2, second moment, m^4, moment of a unit pressure, m^3, of a square with a chamber `at` off its middle."""
    block, hole = side**2, width * depth
    axis = -hole * at / (block - hole)
    inertia = side**4 / 12 + block * axis**2 - (width * depth**3 / 12 + hole * (at - axis) ** 2)
    return block - hole, inertia, hole * (axis - at)


def segment_motion(truth: SegmentTruth, pressure: float, time: Array, opens: float) -> tuple[Array, Array]:
    """Tip from the mounting, and heading: the chamber fills through an orifice, dp/dt = k/C sqrt(p0 - p)."""
    area, inertia, moment = hollow(0.025, 0.012, 0.008, -0.006)
    E = truth.youngs_modulus
    rod = Rod(
        truth.length,
        E * inertia,
        np.inf,
        truth.density * area,
        truth.density * inertia,
        truth.relaxation_time,
        truth.creep,
    )
    within = _filling(truth, pressure)

    def drive(p: float) -> float:
        return moment * truth.gain(p) * p

    return _since(time, opens, truth.length, lambda t: rod.move(t, G, lambda t: 0.0, within, drive, truth.gain))


def _filling(truth: SegmentTruth, supply: float) -> Callable[[float], float]:
    """Pressure in the chamber by the time since the valve opened; with w = sqrt(lack of pressure), dw/dt = -k / 2 C."""
    w = np.linspace(0, np.sqrt(supply), 400)

    def lasts(pressures: Array) -> Array:
        """To lose what is lacking, down from w, s."""
        gain = np.array([truth.gain(p) for p in pressures]) / truth.gain(0.0)
        slowness = truth.fill_time / np.sqrt(10e3) * (1 + truth.swelling * (gain**2 - 1))  # the slope of gain x p
        return np.concatenate([[0.0], np.cumsum((slowness[1:] + slowness[:-1]) / 2 * np.diff(w))])

    fills, empties = lasts(supply - w**2), lasts(w**2)

    def pressure(t: float) -> float:
        if t < truth.open_for:
            return float(supply - np.interp(fills[-1] - t, fills, w) ** 2)
        return float(np.interp(empties[-1] - (t - truth.open_for), empties, w) ** 2)

    return pressure


def write_segment(
    folder: Path,
    duration: float = 3.2,
    truth: SegmentTruth = SEGMENT,
    seed: int = 2,
    pressures: tuple[int, ...] = SEGMENT_PRESSURES,
) -> Path:
    """Motion capture at each pressure, kPa: x is down, along the segment, which bends toward -y; 100 Hz, mm."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(seed)
    for i, pressure in enumerate(pressures):
        time = np.arange(0, duration, 0.01)
        place, heading = segment_motion(truth, 1e3 * pressure, time, truth.opens + 0.07 * i)
        z, x = np.array([1.0, 0, 0]), np.array([0, -0.9938, 0.1111]) / np.hypot(0.9938, 0.1111)
        axes = np.column_stack([x, np.cross(z, x), z])
        tips = [(-0.001 + 0.005j, 0.026), (0.008j, -0.026), (0.001 + 0.027j, 0.002)]
        bases = [(0.05j, 0.02), (0.001 + 0.03j, -0.05), (0.002 - 0.01j, 0.05), (-0.001 + 0.05j, -0.03)]
        moved = (place + truth.mounting, heading)
        origin = [0.0225, 0.0747, -0.0239]
        _write_markers(folder / f"{pressure}kPa.csv", time, moved, tips, bases, origin, axes, random, truth.mounting)
    return folder


def _since(time: Array, begin: float, length: float, moves: Callable) -> tuple[Array, Array]:
    """At rest and straight before an event."""
    place, heading = np.full(len(time), length, dtype=complex), np.zeros(len(time))
    later = time > begin
    found = moves(np.concatenate([[0.0], time[later] - begin]))
    place[later], heading[later] = found[0][1:], found[1][1:]
    return place, heading


def _write_markers(
    file: Path, time: Array, tip: tuple[Array, Array], tips: Sequence, bases: Sequence, origin: Sequence[float],
    axes: Array, random: np.random.Generator, mounting: complex = 0.0,
) -> None:  # fmt: skip
    """A table of markers, mm: each given by its place in its body's frame, in the plane and across."""
    place, heading = tip
    planar = {f"tip_{i}": (place + np.exp(1j * heading) * p, y) for i, (p, y) in enumerate(tips, 1)}
    planar |= {f"base_{i}": (np.full(len(time), mounting + p), y) for i, (p, y) in enumerate(bases, 1)}
    columns, values = ["time_s"], [time]
    for name, (p, y) in planar.items():
        points = origin + np.column_stack([p.imag, np.full(len(time), y), p.real]) @ axes.T
        points += random.normal(0, MARKER_NOISE, points.shape)
        columns += [f"{name}_{axis}_mm" for axis in "xyz"]
        values += list(1e3 * points.T)
    rows = [",".join([f"{row[0]:.2f}", *(f"{value:.3f}" for value in row[1:])]) for row in np.column_stack(values)]
    file.write_text("\n".join([",".join(columns), *rows]) + "\n", encoding="utf-8")


# ---- the arm


@dataclass(frozen=True)
class ArmTruth:
    """Of an arm of two sections, each an arc that lengthens: what its wires, bodies and chambers are like."""

    spacing: float = 0.043
    wire_offsets: tuple[tuple[float, float], ...] = ((0.081, 0.0828), (0.102, 0.1005))  # inner, outer of each section
    crossing: float = 0.03  # of the bend of the first section, less that the passing wires show
    bow: float = 0.0  # m/rad^2, that a section is longer than its wires
    lengths: tuple[float, float] = (0.12, 0.125)  # without pressure
    lengthens: float = 1.2e-7  # m/Pa, each section, by each of its chambers
    bends: tuple[tuple[float, ...], ...] = ((6e-6, -5e-6, 1e-6), (5.5e-6, -6.5e-6, -1e-6))  # rad/Pa, at once, unloaded
    rest: tuple[float, float] = (0.03, -0.04)  # rad, without pressure
    creep: tuple[float, float] = (0.25, 2.0)  # share, s
    base: float = 0.003  # m, of the first section across
    tilt: float = 0.035  # rad
    coupling: float = 0.003  # m, across, between the sections
    bodies: tuple[complex, complex] = (0.012 + 0.003j, 0.018 - 0.002j)  # from the ends of the sections
    turns: tuple[float, float] = (0.03, -0.02)  # rad, of the bodies' axes
    delay: float = 0.08  # s, of wires and pressures behind motion capture
    wire_noise: float = 1e-4
    body_noise: float = 1e-4


ARM = ArmTruth()
ARM_NOMINAL = ArmTruth(
    wire_offsets=((0.05, 0.05), (0.05, 0.05)), crossing=0.0, rest=(0.0, 0.0), base=0.0, tilt=0.0, coupling=0.0,
    bodies=(0.0, 0.0), turns=(0.0, 0.0), delay=0.0,
)  # fmt: skip
PSI = 6894.757
TRIALS = {  # which chambers are under pressure; 2 and 4 bend the sections in opposite directions
    "trial_1": ((0,), (0,)), "trial_2": ((0,), (1,)), "trial_3": ((1,), (1,)), "trial_4": ((1,), (0,)),
    "trial_5": ((0, 2), (1, 2)), "trial_6": ((1, 2), (0, 2)),
}  # fmt: skip


def arm_state(truth: ArmTruth, trial: str, time: Array) -> tuple[Array, Array, Array]:
    """Pressures (T, 2, 3), bends and lengths (T, 2) of the sections."""
    on = np.zeros((2, 3))
    for section, chambers in enumerate(TRIALS[trial]):
        on[section, list(chambers)] = 1
    level = np.interp(time, [0.5, 1.5, 4.0, 4.5, 7.0, 7.6], [0.0, 1.0, 1.0, 0.6, 0.6, 0.0])
    pressure = 9e4 * level[:, None, None] * on + 7e3
    elastic = np.array(truth.rest) + (pressure * np.array(truth.bends)).sum(axis=-1)
    share, lasts = truth.creep
    z, bend, bends, step = np.zeros(2), np.zeros(2), [], time[1] - time[0]
    for now in elastic:
        bend = now + share * z + arm_sag(bend)
        z = z + (1 - np.exp(-step / lasts)) * (bend - z)
        bends.append(bend)
    return pressure, np.array(bends), np.array(truth.lengths) + truth.lengthens * pressure.sum(axis=-1)


def arm_sag(bends: Array) -> Array:
    """By how much weight bends two sections of 0.12 m, which hang and are bent already: change of height by bend."""
    area, inertia, _ = hollow(0.05, 0.03, 0.01, -1e-3)
    length, weight = 0.12, 1000 * area * G
    upper, lower = (np.exp(1j * bend * _X) for bend in bends)
    turned = np.exp(1j * bends[0])
    below = 1j * turned * length * (_WEIGHTS * (1 - _X) * lower).sum()
    of_upper = length * (_WEIGHTS * (2 - _X) * 1j * _X * upper).sum() + below
    of_lower = turned * length * (_WEIGHTS * (1 - _X) * 1j * _X * lower).sum()
    return weight * length * np.real([of_upper, of_lower]) / (4e6 * inertia / length)


def arm_bodies(truth: ArmTruth, bends: Array, lengths: Array) -> tuple[Array, Array]:
    """Places (T, 2) of the bodies, z down and i x, and their headings: arcs between rigid parts."""
    place, heading = np.full(len(bends), 1j * truth.base), np.full(len(bends), truth.tilt)
    places, headings = [], []
    for section in range(2):
        bend = np.where(np.abs(bends[:, section]) < 1e-9, 1e-9, bends[:, section])
        chord = lengths[:, section] * (np.exp(1j * bend) - 1) / (1j * bend)
        place, heading = place + chord * np.exp(1j * heading), heading + bend
        places.append(place + truth.bodies[section] * np.exp(1j * heading))
        headings.append(heading + truth.turns[section])
        place = place + 1j * truth.coupling * np.exp(1j * heading)
    return np.column_stack(places), np.column_stack(headings)


def arm_wires(truth: ArmTruth, bends: Array, lengths: Array) -> Array:
    """Lengths of the wires, (T, 2, 2) m: section at whose end, inner and outer; all run from the base."""
    shown = bends - truth.crossing * np.column_stack([np.zeros(len(bends)), bends[:, 0]])
    mean, half = lengths - truth.bow * bends**2, shown * truth.spacing / 2
    sides = np.stack([mean - half, mean + half], axis=-1)
    return sides.cumsum(axis=1) + np.array(truth.wire_offsets).cumsum(axis=0)


def write_arm(
    folder: Path, duration: float = 9.0, truth: ArmTruth = ARM, seed: int = 3, trials: Sequence[str] = tuple(TRIALS)
) -> Path:
    """A file a trial, about 30 rows a second: psi, V (5 V for a meter), m and quaternions x, y, z, w; z is up."""
    folder.mkdir(parents=True, exist_ok=True)
    random = np.random.default_rng(seed)
    for trial in trials:
        time = np.arange(0, duration, 1 / 30) + random.uniform(0, 0.004, round(duration * 30))
        fine = np.arange(-1.0, duration + 0.1, 0.005)
        pressure, bends, lengths = arm_state(truth, trial, fine)
        wires = arm_wires(truth, bends, lengths) + random.normal(0, truth.wire_noise, (len(fine), 2, 2))
        then = np.searchsorted(fine, time - truth.delay)
        places, headings = (values[np.searchsorted(fine, time)] for values in arm_bodies(truth, bends, lengths))
        upper, lower = (pressure[then, section] / PSI for section in (0, 1))
        (left_upper, right_upper), (left_total, right_total) = 5 * wires[then].transpose(1, 2, 0)
        poses = [_pose(np.zeros(len(time)), np.zeros(len(time)), random, truth)]
        for i in range(2):
            flipped = (trial == "trial_2") & (i == 1) & (time > 3) & (time < 3.5)
            poses.append(_pose(places[:, i], headings[:, i] + np.pi * flipped, random, truth))
        columns = [time, *lower.T, *lower.T, *upper.T, *upper.T, left_upper, right_upper, right_total, left_total]
        table = np.column_stack([*columns, *poses])
        lines = [",".join(f"{value:.6f}" for value in row) for row in table]
        lines[20] = lines[20].replace(",", ",[", 1).replace(",", "],", 2).replace("],", ",", 1)
        lines.insert(40, "lost, lost")
        (folder / f"{trial}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def _pose(place: Array, heading: Array, random: np.random.Generator, truth: ArmTruth) -> Array:
    """Columns of a body: where it is, z up; and, turned about the axis y of the file, its quaternion."""
    p = np.column_stack([place.imag, np.zeros(len(place)), -place.real])
    p += np.array([0.007, -0.211, 0.559]) + random.normal(0, truth.body_noise, (len(place), 3))
    half = -heading / 2
    zeros = np.zeros(len(place))
    return np.column_stack([p, zeros, np.sin(half), zeros, np.cos(half)])


# ---- a finger of the project, calibrated


@dataclass(frozen=True)
class CalibrationTruth:
    """Of models/grippers/finger.urdf with four sections per side, which bends further than nominal."""

    bend_ratio: float = 1.12
    gains: tuple[float, ...] = (1.05, 0.97, 1.02, 0.95, 0.96, 1.03, 1.04, 0.98)  # inner, outer; their mean is 1
    offsets: tuple[float, ...] = (0.004, -0.003, 0.002, 0.0, -0.002, 0.003, -0.004, 0.001)
    noise: float = 3e-4
    lag: float = 0.07  # s, of the bend behind the pressure


CALIBRATION = CalibrationTruth()


def free_bending(truth: CalibrationTruth = CALIBRATION, seed: int = 4) -> tuple[Array, Array, Array]:
    """Times, pressures, and strain (T, 2, 4) of a weightless finger whose pressure steps, sampled every 20 ms."""
    steps = np.array([0, 5e4, 1e5, 1.5e5, 1e5, 5e4, -2e4, 3e4, 1.2e5, 0.0])
    time = np.arange(0, 0.8 * len(steps), 0.02)
    pressure = steps[np.minimum((time / 0.8 + 1e-9).astype(int), len(steps) - 1)]
    driven, now = [], 0.0
    for p in pressure:
        now += (1 - np.exp(-0.02 / truth.lag)) * (p - now)
        driven.append(now)
    s = (np.arange(240) + 0.5) / 240  # along the finger, which tapers
    thick, deep, center = 0.02 - 0.001 * s, 0.01 - 0.0005 * s, -1e-3 + 5e-5 * s
    E, layer = 2.67e5, 2e-4
    parts = [(E, 0.02, thick, 0 * s), (-E, 9e-3, deep, center), (1e9 - E, 0.02, layer, thick / 2 - layer / 2)]
    weights = [modulus * width * height for modulus, width, height, _ in parts]
    axis = sum(weight * at for weight, (*_, at) in zip(weights, parts, strict=True)) / sum(weights)
    of_part = [w * (h**2 / 12 + (at - axis) ** 2) for w, (*_, h, at) in zip(weights, parts, strict=True)]
    curvature = truth.bend_ratio * 9e-3 * deep * (axis - center) / sum(of_part)  # per pressure
    in_sections = curvature.reshape(4, -1).mean(axis=1)
    paths = np.array([0.017 / 2, -0.017 / 2]) - axis[-1]  # in the thinner end, from the neutral axis
    strain = -np.array(driven)[:, None, None] * in_sections * paths[:, None]
    gains, offsets = (np.reshape(values, (2, 4)) for values in (truth.gains, truth.offsets))
    return time, pressure, gains * strain + offsets + np.random.default_rng(seed).normal(0, truth.noise, strain.shape)
