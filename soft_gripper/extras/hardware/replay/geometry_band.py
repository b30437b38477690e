"""How far the bodies of an arm may be from where its wires place them, and where an arm leaves what was fitted.

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
from soft_gripper.extras.hardware.least_squares import Fit
from soft_gripper.extras.hardware.left_out_regions import (
    LeftOut,
    disagreement,
    fitted_disagreement,
    learned_widths,
    regions_left_out,
)
from soft_gripper.extras.hardware.replay.arm_estimation import ArmRecording
from soft_gripper.extras.hardware.replay.geometry_fit import ArmGeometry, measured, places, without
from soft_gripper.extras.hardware.replay.warnings_of_states import disagreeing, extrapolated
from soft_gripper.extras.hardware.scoring import ball_radius, ball_std
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.fitted_states import FittedStates, Widths, spread_of

_STEP = 1e-3  # m, of a wire, for differences
_STRIDE = 3  # one in so many samples counts as a fitted state
_SHAPE = 2  # numbers of a state that are read, first; the others are the drive's


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
        states = section_states(geometry, recording)
        return _shape_distances(self.sections, states)


def _shape_distances(sections: Sequence[FittedStates], states: Sequence[Array]) -> Array:
    """Distance of every section from fitted states by length and bend, (T, S), in spreads."""
    shape = slice(_SHAPE)
    pairs = zip(sections, states, strict=True)
    return np.stack([fitted.part(shape).distance(of[:, shape]) for fitted, of in pairs], axis=-1)


def section_states(geometry: ArmGeometry, recording: ArmRecording) -> list[Array]:
    """The states of every section: length (m), bend (rad) and pressures of its chambers (Pa), (T, 2 + chambers)."""
    of, chambers = geometry.wires.sections(recording.inner, recording.outer), np.array(recording.chamber_sections)
    return [
        np.column_stack([of.length[:, section], of.theta[:, section], recording.pressures[:, chambers == section]])
        for section in range(of.theta.shape[-1])
    ]


def learn_band(fitted: Fit[ArmGeometry], recordings: Sequence[ArmRecording], finger: Finger) -> GeometryBand:
    """The band of an arm, from the recordings that its geometry was fitted to."""
    geometry = fitted.model
    by_recording = [section_states(geometry, one) for one in recordings]
    together = [np.concatenate(parts) for parts in zip(*by_recording, strict=True)]
    sections = tuple(map(FittedStates, together, _spreads(together)))

    def without(region: NDArray[np.bool_]) -> LeftOut:
        return _left_out(fitted, recordings, finger, sections, region)

    errors = np.concatenate([_errors(geometry, one, finger) for one in recordings])
    seen = errors[np.isfinite(errors).all(axis=-1)]
    widths = learned_widths(
        seen, [*regions_left_out([section.part(slice(_SHAPE)).regions() for section in sections], without)]
    )
    disagreed = [
        fitted_disagreement([states[section] for states in by_recording], of.spread, _SHAPE)
        for section, of in enumerate(sections)
    ]
    return GeometryBand(sections, widths, max(disagreed))


def _left_out(
    fitted: Fit[ArmGeometry],
    recordings: Sequence[ArmRecording],
    finger: Finger,
    sections: Sequence[FittedStates],
    region: NDArray[np.bool_],
) -> LeftOut:
    """Errors in a region of states of all recordings one after the other, by a fit to what is not in it."""
    hidden = np.split(region, np.cumsum([len(one.time) for one in recordings])[:-1])
    geometry = without(fitted, hidden)
    kept = [states.leave_out(region) for states in sections]
    errors, grown = [], []
    for recording, left_out in zip(recordings, hidden, strict=True):
        rows = np.flatnonzero(left_out & np.isfinite(recording.positions).all(axis=-1))[::_STRIDE]
        if len(rows):
            distances = _shape_distances(kept, [of[rows] for of in section_states(fitted.model, recording)])
            errors.append(_errors(geometry, recording, finger)[rows])
            grown.append(_grown(geometry, recording, finger, distances, rows))
    none = np.zeros((0, len(sections)))
    of_region = np.concatenate([none, *errors]), np.concatenate([none, *grown])
    seen = np.isfinite(of_region[0]).all(axis=-1)
    return LeftOut(of_region[0][seen], of_region[1][seen])


def _spreads(sections: Sequence[Array]) -> list[Array]:
    """Units of the states of every section: those of lengths, bends and pressures of the whole arm."""
    length, bend = (spread_of(np.stack([states[:, kind] for states in sections], -1)) for kind in range(_SHAPE))
    pressure = spread_of(np.concatenate([states[:, _SHAPE:] for states in sections], axis=-1))
    return [np.array([length, bend, *[pressure] * (states.shape[-1] - _SHAPE)]) for states in sections]


def _errors(geometry: ArmGeometry, recording: ArmRecording, finger: Finger) -> Array:
    at, _ = places(geometry, finger, *geometry.wires.sections(recording.inner, recording.outer))
    errors: Array = np.abs(at - measured(recording, geometry.delay)[0])
    return errors


def _grown(
    geometry: ArmGeometry,
    recording: ArmRecording,
    finger: Finger,
    distances: Array,
    rows: NDArray[np.int_] | slice = slice(None),
) -> Array:
    """Radius of every body, (T, S), that a growth of 1 gives at distances (T, S)."""
    of = geometry.wires.sections(recording.inner[rows], recording.outer[rows])
    at, _ = places(geometry, finger, *of)
    wrong, moved = _STEP * np.sqrt(distances), []
    for one in np.eye(distances.shape[-1]):
        moved += [places(geometry, finger, of.theta + np.sqrt(2) * one * wrong / geometry.wires.spacing, of.length)[0]]
        moved += [places(geometry, finger, of.theta, of.length + one * wrong / np.sqrt(2))[0]]
    return ball_radius(as_points(np.stack(moved) - at)) / _STEP


@dataclass(frozen=True)
class BodyBand:
    """The band of the bodies in T samples of a recording, and where these are far from what was fitted."""

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
    """The band of every body about its place by arcs; `variants` of zeroed wires, see `zeroing`."""
    distances = band.distances(geometry, recording)
    grown = _grown(geometry, recording, finger, distances)
    radius = band.widths.band(grown)
    if variants:
        at, *variant_places = (
            places(one, finger, *one.wires.sections(recording.inner, recording.outer))[0]
            for one in (geometry, *variants)
        )
        radius = np.hypot(radius, ball_radius(as_points(np.stack(variant_places) - at)))
    return BodyBand(radius, distances, band.widths.is_far(grown).any(axis=-1))


def extrapolations(band: GeometryBand, geometry: ArmGeometry, recording: ArmRecording, body: BodyBand) -> list[str]:
    """Where a recording is far from what was fitted, as text: the furthest state of a section, or none."""
    states = section_states(geometry, recording)

    def state(row: int, section: int) -> str:
        length, bend, *pressures = states[section][row]
        driven = ", ".join(f"{1e-3 * pressure:.0f}" for pressure in pressures)
        at = f"{1e3 * length:.0f} mm long and {np.degrees(bend):.0f} degrees bent under {driven} kPa"
        return f"section {section + 1} {at}"

    return extrapolated(recording.time, body.distance, body.is_far, state)


def disagreements(band: GeometryBand, geometry: ArmGeometry, recording: ArmRecording) -> list[str]:
    """Sections whose readings and pressures disagree more than in any fitted recording, as text."""
    said: list[str] = []
    for section, (fitted, states) in enumerate(zip(band.sections, section_states(geometry, recording), strict=True)):
        apart = disagreement(fitted, states, _SHAPE)
        said += disagreeing(f"wires and pressures of section {section + 1}", apart, band.disagreement)
    return said
