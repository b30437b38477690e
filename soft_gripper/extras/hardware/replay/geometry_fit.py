"""Fits the geometry of an arm: wire offsets, rigid parts, tilt and the delay of the wires; and its drive.

The geometry is the most probable one, given its prior widths (`_STDS`) and the bodies in motion capture. Errors
of the model are correlated in time, so the samples of a recording count as a few independent ones.

Without these widths, offsets, tilt and rigid lengths of the fitted recordings compensate for each other, and the
held-out recording is estimated worse.

The drive is a torque per pressure for each chamber, and creep.

With the bends of training recordings known, the balance  k q = G p + u_0 + w(q) + memory  is linear in the gains G and
in the torque u_0 without pressure; creep of a given share and time filters both sides alike. So the gains follow by
least squares for every creep on a grid, and the creep with the smallest residual is chosen.

If the wires were set anew, only two offsets per section have changed, of its bend and its length. They follow from the
poses of the bodies in the first seconds of a recording; all else stays as it was fitted. Errors of the model there go
into the offsets: the band of the bodies in that pose makes the offsets uncertain, and these every other pose.

Geometry is fitted with arcs, and the drive with the resulting bends, on other recordings than the one that is
estimated: estimators then differ only in the bends of the joints within a section.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from soft_gripper.arrays import Array, Planar
from soft_gripper.extras.hardware.least_squares import Fit, Problem, fit
from soft_gripper.extras.hardware.replay.arm_estimation import PERIOD, ArmRecording, RigidParts, stretched_arm
from soft_gripper.extras.hardware.replay.finger_estimation import first_rows
from soft_gripper.extras.hardware.replay.wire_lengths import WireGeometry
from soft_gripper.extras.hardware.scoring import Split, leave_one_out, predictions
from soft_gripper.files.document import require
from soft_gripper.fingers.creep import recursion
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.kinematics import as_planar, as_points, gravity_torque, planar_vector

_SAMPLE_STRIDE = 6  # one in so many samples is fitted
_INDEPENDENT_SAMPLES = 20.0  # samples of a recording
_POSITION_STD, _HEADING_STD = 3e-3, 0.06  # m and rad, standard deviations of the fitted measurements
# Prior standard deviations for every section, m and rad: wire offsets, passing wires, bow, rigid
# parts across and along, axes of bodies; and of the base.
_STDS = {
    "bend_offset": 0.1,
    "crossing": 0.05,
    "length_offset": 0.03,
    "bow": 0.01,
    "coupling": 0.005,
    "body_along": 0.02,
    "body_across": 0.005,
    "turn": 0.05,
}
_BASE_STD, _TILT_STD, _DELAY_STD = 0.005, 0.03, 0.15  # m, rad, s


@dataclass(frozen=True)
class ArmGeometry:
    """Geometry of an arm, for body positions from wire lengths."""

    wires: WireGeometry
    parts: RigidParts
    delay: float  # s, delay of the wires relative to motion capture


def fit_geometry(recordings: Sequence[ArmRecording], finger: Finger) -> Fit[ArmGeometry]:
    """Fits the most probable geometry of an arm; residuals are those of the prior, then of each recording."""
    nominal, spacing = _nominal_offsets(recordings), recordings[0].spacing

    def build_geometry(x: Array) -> ArmGeometry:
        return _build_geometry(x, nominal, spacing)

    def residuals(x: Array) -> Array:
        return np.concatenate([x, *(_residuals(build_geometry(x), recording, finger) for recording in recordings)])

    return fit(Problem(build_geometry, residuals, options={"max_nfev": 30}), np.zeros(len(_STDS) * len(nominal) + 3))


def geometry_without(fitted: Fit[ArmGeometry], left_out: Sequence[NDArray[np.bool_]]) -> ArmGeometry:
    """First-order fit of the geometry to the samples that are not left out, by their mask for every recording, (T,)."""
    sections = len(fitted.model.wires.bend_offsets)
    masks = [np.ones(len(fitted.x), bool)]
    for rows in left_out:
        masks += [np.repeat(~rows[::_SAMPLE_STRIDE], axes * sections) for axes in (2, 1)]  # places, then headings
    return fitted.build_model(fitted.x + fitted.change_without(np.concatenate(masks)))


def body_poses(geometry: ArmGeometry, finger: Finger, theta: Array, length: Array) -> tuple[Planar, Array]:
    """Positions of the bodies in B, and their headings, if the sections are arcs: (T, S) m, (T, S) rad."""
    ends = finger.section_ends(theta.shape[-1])
    q = np.repeat(theta / np.diff(ends), np.diff(ends), axis=-1)
    _, positions, headings = stretched_arm(geometry.parts, q, length, ends)
    return positions, headings


def measured_poses(recording: ArmRecording, delay: float) -> tuple[Planar, Array]:
    """Body positions and headings at the time of the wire readings, a `delay` (s) earlier: (T, S) m, (T, S) rad."""
    rows = np.clip(np.arange(len(recording.time)) - delay / PERIOD, 0, len(recording.time) - 1)
    earlier_rows, fraction = rows.astype(int), (rows % 1)[:, None]
    later_rows = np.minimum(earlier_rows + 1, len(recording.time) - 1)
    positions: Planar = (1 - fraction) * recording.positions[earlier_rows] + fraction * recording.positions[later_rows]
    return positions, (1 - fraction) * recording.headings[earlier_rows] + fraction * recording.headings[later_rows]


def _nominal_offsets(recordings: Sequence[ArmRecording]) -> Array:
    """Mean distances from body to body minus wire lengths, (S,) m, at which the search starts."""
    differences = []
    for recording in recordings:
        spans = np.abs(np.diff(recording.positions, axis=1, prepend=0.0))
        wires = np.diff((recording.inner + recording.outer) / 2, axis=1, prepend=0.0)
        differences.append(np.nanmean(spans - wires, axis=0))
    return np.mean(differences, axis=0)


def _build_geometry(x: Array, nominal: Array, spacing: float) -> ArmGeometry:
    """Builds a geometry from standard normal numbers: those of the sections by kind, then base, tilt and delay."""
    scaled = {
        name: row * width for (name, width), row in zip(_STDS.items(), x[:-3].reshape(-1, len(nominal)), strict=True)
    }
    lengths = nominal + scaled["length_offset"]
    wires = WireGeometry(spacing, scaled["bend_offset"], scaled["crossing"], lengths, scaled["bow"])
    bodies = planar_vector(scaled["body_across"], scaled["body_along"])
    couplings = planar_vector(scaled["coupling"], 0.0)
    base, tilt, delay = x[-3:] * (_BASE_STD, _TILT_STD, _DELAY_STD)
    return ArmGeometry(wires, RigidParts(planar_vector(base, 0.0), tilt, couplings, bodies, scaled["turn"]), delay)


def _residuals(geometry: ArmGeometry, recording: ArmRecording, finger: Finger) -> Array:
    rows = slice(None, None, _SAMPLE_STRIDE)
    wires = geometry.wires.sections(recording.inner[rows], recording.outer[rows])
    positions, headings = body_poses(geometry, finger, *wires)
    true_positions, true_headings = (values[rows] for values in measured_poses(recording, geometry.delay))
    position_misfits, turns = ((positions - true_positions) / _POSITION_STD, (headings - true_headings) / _HEADING_STD)
    misfits = np.concatenate([as_points(position_misfits).ravel(), turns.ravel()])
    return np.nan_to_num(misfits) * np.sqrt(_INDEPENDENT_SAMPLES / len(positions))


_TYPICAL_OFFSETS = 1.0, 0.02  # rad and m, of a bend and a length


@dataclass(frozen=True)
class ZeroedGeometry:
    """Copy of a geometry with its offsets estimated anew."""

    geometry: ArmGeometry
    variants: tuple[ArmGeometry, ...]  # one standard deviation away, in each of the independent directions


def zero_geometry(
    geometry: ArmGeometry, recording: ArmRecording, finger: Finger, seconds: float, std: Array
) -> ZeroedGeometry:
    """Finds the offsets that place the bodies best in the first seconds of a recording, in which their pose is known.

    `std` is that of the bodies about their places along an axis, (S,) m.
    """
    rows = first_rows(recording.name, recording.time, seconds)
    measured_positions, measured_headings = (values[rows] for values in measured_poses(recording, geometry.delay))
    is_seen = np.isfinite(measured_positions + measured_headings).all(axis=-1)
    expected = "its first seconds must show all bodies: give more, or cut what comes before"
    require(bool(is_seen.any()), recording.name, "--zero", seconds, expected)
    inner_wires, outer_wires = recording.inner[rows][is_seen], recording.outer[rows][is_seen]

    def build_geometry(x: Array) -> ArmGeometry:
        """The geometry with other offsets, of the bends (rad), then of the lengths (m)."""
        bends, lengths = x.reshape(2, -1)
        wires = geometry.wires
        shifted = replace(wires, bend_offsets=wires.bend_offsets + bends, length_offsets=wires.length_offsets + lengths)
        return replace(geometry, wires=shifted)

    def residuals(x: Array) -> Array:
        shifted = build_geometry(x)
        positions, headings = body_poses(shifted, finger, *shifted.wires.sections(inner_wires, outer_wires))
        shifts = (positions - measured_positions[is_seen]).mean(axis=0) / std
        turns = (headings - measured_headings[is_seen]).mean(axis=0) / _HEADING_STD
        return np.concatenate([as_points(shifts).ravel(), turns])

    problem = Problem(build_geometry, residuals, options={"x_scale": np.repeat(_TYPICAL_OFFSETS, len(std))})
    zero_fit = fit(problem, np.zeros(2 * len(std)))
    deviations = np.linalg.cholesky(zero_fit.covariance).T
    variants = tuple(build_geometry(zero_fit.x + deviation) for deviation in deviations)
    return ZeroedGeometry(zero_fit.model, variants)


_CREEP_SHARES, _CREEP_TIMES = (0.1, 0.25, 0.4, 0.55, 0.7), (0.5, 1.0, 2.0, 4.0, 8.0)
_RIDGE_SHARE = 1e-2  # of the mean square of a chamber's pressure; matters for chambers that are hardly used


@dataclass(frozen=True)
class ArmDrive:
    """The drive of an arm of N joints with C chambers."""

    finger: Finger  # with creep
    gains: Array  # (N, C) N m/Pa
    rest: Array  # (N,) N m, torque without pressure
    angle_std: float  # rad, unexplained angle of a joint


def fit_drive(recordings: Sequence[ArmRecording], geometry: ArmGeometry, finger: Finger, gravity: Array) -> ArmDrive:
    """Drive that explains the bends of the sections best; `gravity` in B, (3,) m/s^2."""
    scale = float(np.sqrt(np.mean(np.concatenate([recording.pressures for recording in recordings]) ** 2)))
    joints = np.diff(finger.section_ends(len(recordings[0].bodies)))
    chambers, balances = np.array(recordings[0].chamber_sections), {}
    for fraction, time in product(_CREEP_SHARES, _CREEP_TIMES):
        branch = CreepBranch(fraction, time)
        balances[branch] = [_balance(branch, recording, geometry, finger, gravity, scale) for recording in recordings]
    best = min(balances, key=lambda branch: _rms_residual(balances[branch], _torques(balances[branch], chambers)))
    torques = np.repeat(_torques(balances[best], chambers).T, joints, axis=0)
    return ArmDrive(
        finger=replace(finger, creep=(best,)),
        gains=torques[:, :-1] / scale,
        rest=torques[:, -1],
        angle_std=_left_out_residual(balances[best], chambers),
    )


# Bends of joints by every input, (T, C + 1): the chambers, then the torque without pressure; and the bends that
# these must explain, (T, S)
_Balance = tuple[Array, Array]


def _balance(
    branch: CreepBranch, recording: ArmRecording, geometry: ArmGeometry, finger: Finger, gravity: Array, scale: float
) -> _Balance:
    """Balance of one recording; pressures are divided by `scale`, Pa."""
    joints = np.diff(finger.section_ends(len(recording.bodies)))
    theta = geometry.wires.sections(recording.inner, recording.outer).theta
    inputs = np.column_stack([recording.pressures / scale, np.ones(len(recording.time))])
    weight = _weight(finger, theta, joints, gravity)
    bends = bend_under(branch, np.concatenate([inputs, weight], axis=1) / finger.stiffness[0])
    return bends[:, : inputs.shape[1]], theta / joints - bends[:, inputs.shape[1] :]


def _torques(balances: Sequence[_Balance], chambers: NDArray[np.int_]) -> Array:
    """Torques of the inputs on the sections, (C + 1, S), by least squares."""
    A, y = (np.concatenate(arrays) for arrays in zip(*balances, strict=True))
    torques = np.zeros((A.shape[1], y.shape[1]))
    for section in range(y.shape[1]):
        columns = np.append(np.flatnonzero(chambers == section), len(chambers))
        ridge = _RIDGE_SHARE * np.mean(A**2) * len(A) * np.diag([1.0] * (len(columns) - 1) + [0.0])
        torques[columns, section] = np.linalg.solve(
            A[:, columns].T @ A[:, columns] + ridge, A[:, columns].T @ y[:, section]
        )
    return torques


def _rms_residual(balances: Sequence[_Balance], torques: Array) -> float:
    """Root mean square of the joint angles not explained by torques, rad."""
    return float(np.sqrt(np.mean(np.concatenate([(y - A @ torques).ravel() for A, y in balances]) ** 2)))


def _left_out_residual(balances: Sequence[_Balance], chambers: NDArray[np.int_]) -> float:
    """Largest residual angle of a recording under torques that are fitted to the others, rad."""

    def fit_torques(fitted: Sequence[_Balance]) -> Callable[[_Balance], float]:
        torques = _torques(fitted, chambers)
        return lambda balance: _rms_residual([balance], torques)

    splits = leave_one_out(balances) if len(balances) > 1 else [Split(balances, balances)]
    return max(predictions(splits, fit_torques))


def bend_under(branch: CreepBranch, torque: Array) -> Array:
    """Bend of joints of unit stiffness that creep, under torques (T, ...) from rest, samples PERIOD apart.

    As in an estimator, the internal angle of a sample follows from the bends before it, each held.
    """
    decay = recursion((branch,), PERIOD).decay.item()
    memory = decay + (1 - decay) * branch.share  # of the internal angle, which bends, too
    return torque + branch.share * lfilter([0.0, 1 - decay], [1.0, -memory], torque, axis=0)


def _weight(finger: Finger, theta: Array, joints: NDArray[np.int_], gravity: Array) -> Array:
    """Mean torque of weight on a joint of every section, (T, S) N m."""
    q = np.repeat(theta / joints, joints, axis=-1)
    torque = gravity_torque(finger, q, as_planar(gravity[::2]))
    return np.add.reduceat(torque, np.concatenate([[0], np.cumsum(joints)[:-1]]), axis=-1) / joints
