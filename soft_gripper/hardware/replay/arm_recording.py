"""The recording of an arm with length sensors, as what estimators are given and scored by."""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.files.document import given, require
from soft_gripper.hardware.recordings.hardware_recording import HardwareRecording

PERIOD = 0.02  # s, between samples; rows are held
MOST_TIME = 3600.0  # s, of a recording


@dataclass(frozen=True)
class ArmRecording:
    """T samples, PERIOD apart, of an arm with S sections and C chambers; NaN where a body is not seen."""

    name: str
    spacing: float  # m, between the wires of the two sides
    time: Array  # (T,) s, from 0
    inner: Array  # (T, S) m, wires from the base to the end of each section
    outer: Array  # (T, S) m
    pressures: Array  # (T, C) Pa
    chamber_sections: tuple[int, ...]  # (C,) that each chamber is in, from 0
    bodies: tuple[str, ...]  # S names, from the base to the tip
    positions: Planar  # (T, S) m in B, of the bodies
    headings: Array  # (T, S) rad


def arm_recording(recording: HardwareRecording) -> ArmRecording:
    """Raises InputError if the recording has not two wires and a body for every section, or no pressures."""
    where, expected = recording.name, "an arm is estimated from length sensors: describe them"
    described = given(recording.config.lengths, where, "lengths", expected)
    measured = given(recording.pressures, where, "pressures", "describe the chambers' pressures")
    wires = {(wire.side, wire.section): recording.lengths[name] for name, wire in described.wires.items()}
    sections = range(1, max(section for _, section in wires) + 1)
    expected = "give two wires that end at each section, on the inner and on the outer side"
    complete = set(wires) == {(side, section) for side in ("inner", "outer") for section in sections}
    require(complete, where, "lengths.wires", list(described.wires), expected)
    moved = {name: pose for name, pose in recording.poses.items() if name != "base"}
    bodies = sorted(moved, key=lambda name: float(np.nanmedian(moved[name].p[:, 2])))
    expected = f"give a body for the end of each of the {len(sections)} sections, besides 'base'"
    require(len(bodies) == len(sections), where, "poses", bodies, expected)
    pressures = recording.config.pressures
    in_sections = (pressures.sections if pressures else None) or []
    fits = len(in_sections) == measured.shape[1] and set(in_sections) <= set(sections)
    require(fits, where, "pressures.sections", in_sections, f"give the section of each chamber, of {len(sections)}")
    read = np.isfinite(np.column_stack([*wires.values(), measured])).all(axis=1)
    require(bool(read.any()), where, "lengths, pressures", None, "no row has all of them")
    seconds = recording.time[read] - recording.time[read][0]
    expected = f"lasts longer than {MOST_TIME:g} s, of which {MOST_TIME / PERIOD:g} samples would be made: cut it"
    require(seconds[-1] <= MOST_TIME, where, "time", float(seconds[-1]), expected)
    time = np.arange(0.0, seconds[-1], PERIOD)
    rows = np.flatnonzero(read)[np.searchsorted(seconds, time + 1e-9, side="right") - 1]
    return ArmRecording(
        name=recording.name,
        spacing=described.spacing,
        time=time,
        inner=np.column_stack([wires["inner", section] for section in sections])[rows],
        outer=np.column_stack([wires["outer", section] for section in sections])[rows],
        pressures=measured[rows],
        chamber_sections=tuple(section - 1 for section in in_sections),
        bodies=tuple(bodies),
        positions=np.column_stack([_planar(moved[name].p) for name in bodies])[rows],
        headings=np.column_stack([_heading(moved[name].R) for name in bodies])[rows],
    )


def _planar(p: Array) -> Planar:
    planar: Planar = p[:, 2] + 1j * p[:, 0]
    return planar


def _heading(R: Array) -> Array:
    """Direction of a body's z axis in the bending plane, rad, less multiples of pi.

    Motion capture sometimes takes a body with symmetric markers to be turned by half a turn: an axis has no sign.
    """
    heading: Array = np.arctan2(R[:, 0, 2], R[:, 2, 2])
    seen = np.isfinite(heading)
    if seen.any():
        angle = np.unwrap(heading[seen], period=np.pi)
        heading[seen] = angle - np.pi * np.round(angle[0] / np.pi)
    return heading
