"""The fitted geometry of an arm: wire offsets, rigid parts, tilt and the delay of the wires.

The most probable values, given their prior widths (`_WIDTHS`) and the positions of the bodies in motion capture. Errors
of the model are correlated in time, so the samples of a recording count as a few independent ones (_INDEPENDENT).

Without these widths, offsets, tilt and rigid lengths of the fitted recordings compensate for each other, and the
held-out recording is estimated worse.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.hardware.replay.arm_recording import PERIOD, ArmRecording
from soft_gripper.hardware.replay.stretched_arm import RigidParts, stretched_arm
from soft_gripper.sensors.wire_lengths import WireCalibration

_EVERY = 6  # samples, of which one is fitted
_INDEPENDENT = 20.0  # samples of a recording
_POSITION, _HEADING = 3e-3, 0.06  # m and rad, errors of what is fitted
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
    """How positions of bodies follow from wire lengths."""

    wires: WireCalibration
    parts: RigidParts
    delay: float  # s, of the wires behind motion capture


def fit_geometry(recordings: Sequence[ArmRecording], finger: Finger) -> ArmGeometry:
    """The geometry of an arm that explains its recordings, which are of one arm, best."""
    sections = len(recordings[0].bodies)
    nominal = _nominal_offsets(recordings)

    def residuals(x: Array) -> Array:
        geometry = _geometry(x, nominal, recordings[0].spacing)
        return np.concatenate([x, *(_misfit(geometry, recording, finger) for recording in recordings)])

    found = least_squares(residuals, np.zeros(len(_WIDTHS) * sections + 3), max_nfev=30)
    return _geometry(found.x, nominal, recordings[0].spacing)


def measured(recording: ArmRecording, delay: float) -> tuple[Planar, Array]:
    """Where the bodies were when what the wires show was so, a `delay` (s) before: (T, S) m, (T, S) rad."""
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
    wires = WireCalibration(spacing, of["bend_offset"], of["crossing"], lengths, of["bow"])
    bodies: Planar = (of["body_along"] + 1j * of["body_across"]).astype(complex)
    couplings: Planar = (1j * of["coupling"]).astype(complex)
    base, tilt, delay = x[-3:] * (_BASE, _TILT, _DELAY)
    return ArmGeometry(wires, RigidParts(1j * base, tilt, couplings, bodies, of["turn"]), delay)


def _misfit(geometry: ArmGeometry, recording: ArmRecording, finger: Finger) -> Array:
    rows, ends = slice(None, None, _EVERY), finger.section_ends(len(recording.bodies))
    theta, length = geometry.wires.sections(recording.inner[rows], recording.outer[rows])
    q = np.repeat(theta / np.diff(ends), np.diff(ends), axis=-1)
    _, positions, headings = stretched_arm(geometry.parts, q, length, ends)
    true_positions, true_headings = (values[rows] for values in measured(recording, geometry.delay))
    apart, turned = (positions - true_positions) / _POSITION, (headings - true_headings) / _HEADING
    misfits = np.concatenate([apart.real.ravel(), apart.imag.ravel(), turned.ravel()])
    return np.nan_to_num(misfits) * np.sqrt(_INDEPENDENT / len(positions))
