"""The fitted geometry of an arm: wire offsets, rigid parts, tilt and the delay of the wires.

The most probable values, given their prior widths (`_WIDTHS`) and the positions of the bodies in motion capture. Errors
of the model are correlated in time, so the samples of a recording count as a few independent ones (_INDEPENDENT).

Without these widths, offsets, tilt and rigid lengths of the fitted recordings compensate for each other, and the
held-out recording is estimated worse.

The fitted drive of an arm: torque per pressure for each chamber, and creep.

With the bends of training recordings known, the balance  k q = G p + u_0 + w(q) + memory  is linear in the gains G and
in the torque u_0 without pressure; creep of a given share and time filters both sides alike. So the gains follow by
least squares for every creep on a grid, and the creep with the smallest residual is chosen.

Geometry is fitted with arcs, and the drive with the resulting bends, on other recordings than the one that is
estimated: estimators then differ only in how they share bends between joints.
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
from soft_gripper.extras.hardware.replay.wire_lengths import WireGeometry
from soft_gripper.extras.hardware.scoring import Split, each_left_out, predictions
from soft_gripper.fingers.creep import recursion
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.kinematics import as_planar, as_points, gravity_torque, in_plane

_SAMPLE_STRIDE = 6  # one in so many samples is fitted
_INDEPENDENT = 20.0  # samples of a recording
_POSITION, HEADING = 3e-3, 0.06  # m and rad, standard deviations of the fitted measurements
# Standard deviations of what is known before, for every section, m and rad: wire offsets, passing wires, bow, rigid
# parts across and along, axes of bodies; and of the base.
_WIDTHS = {
    "bend_offset": 0.1,
    "crossing": 0.05,
    "length_offset": 0.03,
    "bow": 0.01,
    "coupling": 0.005,
    "body_along": 0.02,
    "body_across": 0.005,
    "turn": 0.05,
}
_BASE, _TILT, _DELAY = 0.005, 0.03, 0.15  # m, rad, s


@dataclass(frozen=True)
class ArmGeometry:
    """The geometry that gives body positions from wire lengths."""

    wires: WireGeometry
    parts: RigidParts
    delay: float  # s, delay of the wires relative to motion capture


def fit_geometry(recordings: Sequence[ArmRecording], finger: Finger) -> Fit[ArmGeometry]:
    """The most probable geometry of the arm of some recordings, with the residuals of the prior, then of each."""
    nominal, spacing = _nominal_offsets(recordings), recordings[0].spacing

    def build_geometry(x: Array) -> ArmGeometry:
        return _geometry(x, nominal, spacing)

    def residuals(x: Array) -> Array:
        return np.concatenate([x, *(_misfit(build_geometry(x), recording, finger) for recording in recordings)])

    return fit(Problem(build_geometry, residuals, options={"max_nfev": 30}), np.zeros(len(_WIDTHS) * len(nominal) + 3))


def without(fitted: Fit[ArmGeometry], left_out: Sequence[NDArray[np.bool_]]) -> ArmGeometry:
    """The geometry that explains best what is kept of its recordings, to the first order.

    Args:
        fitted: fitted to all.
        left_out: samples of every recording, (T,) each.
    """
    sections = len(fitted.model.wires.bend_offsets)
    kept = [np.ones(len(fitted.x), bool)]
    for rows in left_out:
        kept += [np.repeat(~rows[::_SAMPLE_STRIDE], count * sections) for count in (2, 1)]  # places, then headings
    return fitted.model_without(np.concatenate(kept))


def places(geometry: ArmGeometry, finger: Finger, theta: Array, length: Array) -> tuple[Planar, Array]:
    """Places of the bodies in B, and their headings, where the sections are arcs: (T, S) m, (T, S) rad."""
    ends = finger.section_ends(theta.shape[-1])
    q = np.repeat(theta / np.diff(ends), np.diff(ends), axis=-1)
    _, positions, headings = stretched_arm(geometry.parts, q, length, ends)
    return positions, headings


def measured(recording: ArmRecording, delay: float) -> tuple[Planar, Array]:
    """Body positions and headings at the time of the wire readings, a `delay` (s) earlier: (T, S) m, (T, S) rad."""
    rows = np.clip(np.arange(len(recording.time)) - delay / PERIOD, 0, len(recording.time) - 1)
    before, share = rows.astype(int), (rows % 1)[:, None]
    after = np.minimum(before + 1, len(recording.time) - 1)
    positions: Planar = (1 - share) * recording.positions[before] + share * recording.positions[after]
    return positions, (1 - share) * recording.headings[before] + share * recording.headings[after]


def _nominal_offsets(recordings: Sequence[ArmRecording]) -> Array:
    """Lengths from body to body less those of the wires, in the mean, (S,) m: where the search begins."""
    differences = []
    for recording in recordings:
        steps = np.abs(np.diff(recording.positions, axis=1, prepend=0.0))
        wires = np.diff((recording.inner + recording.outer) / 2, axis=1, prepend=0.0)
        differences.append(np.nanmean(steps - wires, axis=0))
    mean: Array = np.mean(differences, axis=0)
    return mean


def _geometry(x: Array, nominal: Array, spacing: float) -> ArmGeometry:
    """From standard normal numbers: those of the sections by kind, then base, tilt and delay."""
    of = {
        name: row * width for (name, width), row in zip(_WIDTHS.items(), x[:-3].reshape(-1, len(nominal)), strict=True)
    }
    lengths = nominal + of["length_offset"]
    wires = WireGeometry(spacing, of["bend_offset"], of["crossing"], lengths, of["bow"])
    bodies, couplings = in_plane(of["body_across"], of["body_along"]), in_plane(of["coupling"], 0.0)
    base, tilt, delay = x[-3:] * (_BASE, _TILT, _DELAY)
    return ArmGeometry(wires, RigidParts(in_plane(base, 0.0), tilt, couplings, bodies, of["turn"]), delay)


def _misfit(geometry: ArmGeometry, recording: ArmRecording, finger: Finger) -> Array:
    rows = slice(None, None, _SAMPLE_STRIDE)
    wires = geometry.wires.sections(recording.inner[rows], recording.outer[rows])
    positions, headings = places(geometry, finger, *wires)
    true_positions, true_headings = (values[rows] for values in measured(recording, geometry.delay))
    apart, turned = (positions - true_positions) / _POSITION, (headings - true_headings) / HEADING
    misfits = np.concatenate([as_points(apart).ravel(), turned.ravel()])
    return np.nan_to_num(misfits) * np.sqrt(_INDEPENDENT / len(positions))


_SHARES, _TIMES = (0.1, 0.25, 0.4, 0.55, 0.7), (0.5, 1.0, 2.0, 4.0, 8.0)
_RIDGE = 1e-2  # of the mean square of a chamber's pressure, for chambers that are hardly used


@dataclass(frozen=True)
class ArmDrive:
    """The drive of an arm of N joints with C chambers."""

    finger: Finger  # with creep
    gains: Array  # (N, C) N m/Pa
    rest: Array  # (N,) N m, torque without pressure
    angle_std: float  # rad, unexplained angle of a joint


def fit_drive(recordings: Sequence[ArmRecording], geometry: ArmGeometry, finger: Finger, gravity: Array) -> ArmDrive:
    """The drive that explains the bends of the sections best; `gravity` in B, (3,) m/s^2."""
    scale = float(np.sqrt(np.mean(np.concatenate([recording.pressures for recording in recordings]) ** 2)))
    joints = np.diff(finger.section_ends(len(recordings[0].bodies)))
    chambers, tried = np.array(recordings[0].chamber_sections), {}
    for share, time in product(_SHARES, _TIMES):
        branch = CreepBranch(share, time)
        tried[branch] = [_balance(branch, one, geometry, finger, gravity, scale) for one in recordings]
    best = min(tried, key=lambda branch: _left(tried[branch], _torques(tried[branch], chambers)))
    of_joints = np.repeat(_torques(tried[best], chambers).T, joints, axis=0)
    return ArmDrive(
        finger=replace(finger, creep=(best,)),
        gains=of_joints[:, :-1] / scale,
        rest=of_joints[:, -1],
        angle_std=_left_out(tried[best], chambers),
    )


# Bends of joints by every input, (T, C + 1), a chamber each and one for what acts without pressure; and the bends that
# these must explain, (T, S)
_Balance = tuple[Array, Array]


def _balance(
    branch: CreepBranch, recording: ArmRecording, geometry: ArmGeometry, finger: Finger, gravity: Array, scale: float
) -> _Balance:
    """Balance of one recording; pressures as parts of `scale`, Pa."""
    joints = np.diff(finger.section_ends(len(recording.bodies)))
    theta = geometry.wires.sections(recording.inner, recording.outer).theta
    driven = np.column_stack([recording.pressures / scale, np.ones(len(recording.time))])
    weight = _weight(finger, theta, joints, gravity)
    bent = bend_under(branch, np.concatenate([driven, weight], axis=1) / finger.stiffness[0])
    return bent[:, : driven.shape[1]], theta / joints - bent[:, driven.shape[1] :]


def _torques(balances: Sequence[_Balance], chambers: NDArray[np.int_]) -> Array:
    """Torques of the inputs on the sections, (C + 1, S), by least squares."""
    A, y = (np.concatenate(part) for part in zip(*balances, strict=True))
    found = np.zeros((A.shape[1], y.shape[1]))
    for section in range(y.shape[1]):
        own = np.append(np.flatnonzero(chambers == section), len(chambers))
        ridge = _RIDGE * np.mean(A**2) * len(A) * np.diag([1.0] * (len(own) - 1) + [0.0])
        found[own, section] = np.linalg.solve(A[:, own].T @ A[:, own] + ridge, A[:, own].T @ y[:, section])
    return found


def _left(balances: Sequence[_Balance], torques: Array) -> float:
    """Root mean square of what torques leave of the joints' angles, rad."""
    return float(np.sqrt(np.mean(np.concatenate([(y - A @ torques).ravel() for A, y in balances]) ** 2)))


def _left_out(balances: Sequence[_Balance], chambers: NDArray[np.int_]) -> float:
    """Residual torque in the recording that the torques fitted to the others explain worst."""

    def fit(fitted: Sequence[_Balance]) -> Callable[[_Balance], float]:
        torques = _torques(fitted, chambers)
        return lambda one: _left([one], torques)

    splits = each_left_out(balances) if len(balances) > 1 else [Split(balances, balances)]
    return max(predictions(splits, fit))


def bend_under(branch: CreepBranch, torque: Array) -> Array:
    """Bend of joints of unit stiffness that creep, under torques (T, ...) from rest, samples PERIOD apart.

    As in an estimator: the internal angle of a sample goes by the bends before it, each held.
    """
    kept = recursion((branch,), PERIOD).kept.item()
    remembered = kept + (1 - kept) * branch.share  # of the internal angle, which bends too
    bends: Array = torque + branch.share * lfilter([0.0, 1 - kept], [1.0, -remembered], torque, axis=0)
    return bends


def _weight(finger: Finger, theta: Array, joints: NDArray[np.int_], gravity: Array) -> Array:
    """Mean torque of weight on a joint of every section, (T, S) N m."""
    q = np.repeat(theta / joints, joints, axis=-1)
    torque = gravity_torque(finger, q, as_planar(gravity[::2]))
    means: Array = np.add.reduceat(torque, np.concatenate([[0], np.cumsum(joints)[:-1]]), axis=-1) / joints
    return means
