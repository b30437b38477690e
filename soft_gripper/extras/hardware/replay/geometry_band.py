"""Bands of an arm's bodies about their positions by its wires, and samples far from the fitted states.

The band of a body is a circle that holds it with a probability of 95 %, learned as `fitted_states` says. Sections err
independently of each other, so each has states of its own: its length and bend. At a distance d from the fitted ones,
each of its wires is taken to be growth sqrt(d) wrong, which moves the bodies behind it as the geometry of the arm says.
The pressures of its chambers are no part of that distance: arcs do not read them, and with them bands predict errors in
left-out recordings no better, and are too wide on days on which other pressures give the same shape.

Where pressures are as in a fitted recording, but bends and lengths are not, readings and drive disagree: the wires may
have been set anew.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.fitted_range import (
    LeftOut,
    disagreement,
    disagreement_warnings,
    extrapolation_warnings,
    fitted_disagreement,
    learned_widths,
    regions_left_out,
)
from soft_gripper.extras.hardware.least_squares import Fit
from soft_gripper.extras.hardware.replay.arm_estimation import ArmRecording
from soft_gripper.extras.hardware.replay.geometry_fit import (
    ArmGeometry,
    body_poses,
    geometry_without,
    measured_poses,
)
from soft_gripper.extras.hardware.scoring import ball_radius, ball_std
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.fitted_states import FittedStates, Widths, spread_of

_WIRE_STEP = 1e-3  # m, of a wire, for differences
_SAMPLE_STRIDE = 3  # one in so many samples counts as a fitted state
_SHAPE_COUNT = 2  # numbers of a state that are read, first; the others are the drive's


@dataclass(frozen=True)
class GeometryBand:
    """The learned errors of an arm with S sections."""

    sections: tuple[FittedStates, ...]  # S, of shape and drive
    widths: Widths  # m, of the bodies, (S,); growth in m of a wire
    disagreement: float  # spreads, most of a fitted recording from the others

    @property
    def std(self) -> Array:
        """Deviations of the bodies about their places along an axis, where the arm was fitted, (S,) m."""
        return ball_std(self.widths.floor, 2)

    def distances(self, geometry: ArmGeometry, recording: ArmRecording) -> Array:
        """Distance of every section from its fitted states, (T, S), in spreads."""
        return _shape_distances(self.sections, section_states(geometry, recording))


def _shape_distances(sections: Sequence[FittedStates], states: Sequence[Array]) -> Array:
    """Distance of every section from fitted states by length and bend, (T, S), in spreads."""
    shape, pairs = slice(_SHAPE_COUNT), zip(sections, states, strict=True)
    return np.stack([fitted.part(shape).distance(section[:, shape]) for fitted, section in pairs], axis=-1)


def section_states(geometry: ArmGeometry, recording: ArmRecording) -> list[Array]:
    """The states of every section: length (m), bend (rad) and pressures of its chambers (Pa), (T, 2 + chambers)."""
    theta, length = geometry.wires.sections(recording.inner, recording.outer)
    chambers = np.array(recording.chamber_sections)
    return [
        np.column_stack([length[:, section], theta[:, section], recording.pressures[:, chambers == section]])
        for section in range(theta.shape[-1])
    ]


def learn_band(fitted: Fit[ArmGeometry], recordings: Sequence[ArmRecording], finger: Finger) -> GeometryBand:
    """The band of an arm, from the recordings that its geometry was fitted to."""
    recording_states = [section_states(fitted.model, recording) for recording in recordings]
    states = [np.concatenate(section) for section in zip(*recording_states, strict=True)]
    sections = tuple(map(FittedStates, states, _units(states)))

    def leave_out(region: NDArray[np.bool_]) -> LeftOut:
        return _left_out(fitted, recordings, finger, sections, region)

    errors = np.concatenate([_errors(fitted.model, recording, finger) for recording in recordings])
    regions = [section.part(slice(_SHAPE_COUNT)).regions() for section in sections]
    widths = learned_widths(errors[np.isfinite(errors).all(axis=-1)], [*regions_left_out(regions, leave_out)])
    limits = [
        fitted_disagreement([states[i] for states in recording_states], section.spread, _SHAPE_COUNT)
        for i, section in enumerate(sections)
    ]
    return GeometryBand(sections, widths, max(limits))


def _left_out(
    fitted: Fit[ArmGeometry],
    recordings: Sequence[ArmRecording],
    finger: Finger,
    sections: Sequence[FittedStates],
    region: NDArray[np.bool_],
) -> LeftOut:
    """Errors in a region of the concatenated states of all recordings, by a fit to the other states."""
    masks = np.split(region, np.cumsum([len(recording.time) for recording in recordings])[:-1])
    geometry = geometry_without(fitted, masks)
    fits = [states.leave_out(region) for states in sections]
    nothing: Array = np.zeros((0, len(sections)))
    errors, widths = [nothing], [nothing]
    for recording, mask in zip(recordings, masks, strict=True):
        rows = np.flatnonzero(mask & np.isfinite(recording.positions).all(axis=-1))[::_SAMPLE_STRIDE]
        if len(rows):
            distances = _shape_distances(fits, [states[rows] for states in section_states(fitted.model, recording)])
            errors.append(_errors(geometry, recording, finger)[rows])
            widths.append(_growth_widths(geometry, recording, finger, distances, rows))
    all_errors = np.concatenate(errors)
    is_seen = np.isfinite(all_errors).all(axis=-1)
    return LeftOut(all_errors[is_seen], np.concatenate(widths)[is_seen])


def _units(sections: Sequence[Array]) -> list[Array]:
    """Units of the states of every section: the spreads of lengths, bends and pressures over the whole arm."""
    length, bend = (spread_of(np.stack([states[:, kind] for states in sections], -1)) for kind in range(_SHAPE_COUNT))
    pressure = spread_of(np.concatenate([states[:, _SHAPE_COUNT:] for states in sections], axis=-1))
    return [np.array([length, bend, *[pressure] * (states.shape[-1] - _SHAPE_COUNT)]) for states in sections]


def _errors(geometry: ArmGeometry, recording: ArmRecording, finger: Finger) -> Array:
    positions, _ = body_poses(geometry, finger, *geometry.wires.sections(recording.inner, recording.outer))
    return np.abs(positions - measured_poses(recording, geometry.delay)[0])


def _growth_widths(
    geometry: ArmGeometry,
    recording: ArmRecording,
    finger: Finger,
    distances: Array,
    rows: NDArray[np.int_] | slice = slice(None),
) -> Array:
    """Radius of every body, (T, S), that a growth of 1 gives at distances (T, S)."""
    theta, length = geometry.wires.sections(recording.inner[rows], recording.outer[rows])
    positions, _ = body_poses(geometry, finger, theta, length)
    steps, changed_positions = _WIRE_STEP * np.sqrt(distances), []
    for mask in np.eye(distances.shape[-1]):
        bends = theta + np.sqrt(2) * mask * steps / geometry.wires.spacing
        changed_positions += [body_poses(geometry, finger, bends, length)[0]]
        changed_positions += [body_poses(geometry, finger, theta, length + mask * steps / np.sqrt(2))[0]]
    return ball_radius(as_points(np.stack(changed_positions) - positions)) / _WIRE_STEP


@dataclass(frozen=True)
class BodyBand:
    """Band of the bodies in T samples of a recording, and samples far from the fitted states."""

    radius: Array  # (T, S) m
    distance: Array  # (T, S) spreads, of the sections
    is_far: NDArray[np.bool_]  # (T)


def body_band(
    band: GeometryBand,
    geometry: ArmGeometry,
    recording: ArmRecording,
    finger: Finger,
    variants: Sequence[ArmGeometry] = (),
) -> BodyBand:
    """The band of every body about its place by arcs; `variants` of zeroed wires, see `zero_geometry`."""
    distances = band.distances(geometry, recording)
    widths = _growth_widths(geometry, recording, finger, distances)
    radius = band.widths.band(widths)
    if variants:
        positions, *variant_positions = (
            body_poses(variant, finger, *variant.wires.sections(recording.inner, recording.outer))[0]
            for variant in (geometry, *variants)
        )
        radius = np.hypot(radius, ball_radius(as_points(np.stack(variant_positions) - positions)))
    return BodyBand(radius, distances, band.widths.is_far(widths).any(axis=-1))


def extrapolations(geometry: ArmGeometry, recording: ArmRecording, body: BodyBand) -> list[str]:
    """Text on samples of a recording far from the fitted states, with the furthest state of a section, if any."""
    sections = section_states(geometry, recording)

    def describe_state(row: int, section: int) -> str:
        length, bend, *pressures = sections[section][row]
        shape = f"{1e3 * length:.0f} mm long and {np.degrees(bend):.0f} degrees bent"
        return (
            f"section {section + 1} {shape} under {', '.join(f'{1e-3 * pressure:.0f}' for pressure in pressures)} kPa"
        )

    return extrapolation_warnings(recording.time, body.distance, body.is_far, describe_state)


def disagreements(band: GeometryBand, geometry: ArmGeometry, recording: ArmRecording) -> list[str]:
    """Sections whose readings and pressures disagree more than in any fitted recording, as text."""
    warnings: list[str] = []
    for section, (fitted, states) in enumerate(zip(band.sections, section_states(geometry, recording), strict=True)):
        distance = disagreement(fitted, states, _SHAPE_COUNT)
        warnings += disagreement_warnings(f"wires and pressures of section {section + 1}", distance, band.disagreement)
    return warnings
