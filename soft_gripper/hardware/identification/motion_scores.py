"""What a simulated motion is off by, and what people look at: settled place, frequency, decrement, rise, creep."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import find_peaks

from soft_gripper.arrays import Array, Planar
from soft_gripper.hardware.identification.free_parameters import Model
from soft_gripper.hardware.identification.measured_motion import MeasuredMotion, settled, turned
from soft_gripper.hardware.identification.simulated_motion import simulated_markers

_EARLY = 0.5  # s after an event, from when on what follows counts as creep
_AROUND = 0.1  # s on either side, over which that is averaged
_PEAKS = 6  # at most, that decide frequency and decrement
_CLEAR = 0.04  # of the settled displacement: what a peak rises over its surroundings


@dataclass(frozen=True)
class MotionScore:
    """A row of the table: one recording, measured beside simulated."""

    recording: str
    role: str  # "fit" or "test"
    settled_error_mm: float  # of the markers, mean
    motion_error_mm: float  # of the markers, mean over the whole motion
    tip_error_percent: float  # largest error of the middle of the markers, of the length of the finger
    settled_turn_deg: float
    simulated_settled_turn_deg: float
    creep_deg: float  # from half a second after the event to the settled turn
    simulated_creep_deg: float
    rise_ms: float  # from a tenth to nine tenths of the turn half a second after the event
    simulated_rise_ms: float
    frequency_hz: float
    simulated_frequency_hz: float
    decrement: float  # logarithmic
    simulated_decrement: float


@dataclass(frozen=True)
class Turn:
    """What the turn of a tip shows."""

    settled: float  # rad
    creep: float  # rad
    rise: float  # s
    frequency: float  # Hz, NaN where it does not swing
    decrement: float


def score(model: Model, motion: MeasuredMotion, role: str) -> MotionScore:
    """Compares a recording, with the events that a fit has found, to the simulation."""
    simulated = simulated_markers(model.finger, model.setup, motion)
    off, moving = np.abs(simulated - motion.markers), motion.time >= motion.events[0]
    middle = np.abs(np.nanmean(simulated - motion.markers, axis=1))[moving]
    places = [settled(motion.time, markers, motion.end) for markers in (simulated, motion.markers)]
    measured, found = (tip_turn(motion, markers) for markers in (motion.markers, simulated))
    return MotionScore(
        motion.name,
        role,
        1e3 * float(np.nanmean(np.abs(places[0] - places[1]))),
        1e3 * float(np.nanmean(off[moving])),
        100 * float(np.nanmax(middle)) / model.finger.length,
        *(float(np.degrees(turn.settled)) for turn in (measured, found)),
        *(float(np.degrees(turn.creep)) for turn in (measured, found)),
        *(1e3 * turn.rise for turn in (measured, found)),
        *(turn.frequency for turn in (measured, found)),
        *(turn.decrement for turn in (measured, found)),
    )


def tip_turn(motion: MeasuredMotion, markers: Planar) -> Turn:
    """What the turn of markers, measured or simulated, shows from a recording's first event to its end."""
    turn, time = turned(markers, motion.reference), motion.time - motion.events[0]
    end = motion.end - motion.events[0]
    late = float(settled(time, turn, end))
    early = float(np.nanmean(turn[np.abs(time - _EARLY) <= _AROUND]))
    rising = (time >= 0) & (time < _EARLY)
    moments = [_first(time[rising], np.abs(turn[rising]), part * abs(early)) for part in (0.1, 0.9)]
    frequency, decrement = _swing(time, _along(motion, markers), end)
    return Turn(late, late - early, moments[1] - moments[0], frequency, decrement)


def _first(time: Array, turn: Array, level: float) -> float:
    """When a turn first reaches a level, between samples, s."""
    above = np.flatnonzero(turn >= level)
    if not len(above) or above[0] == 0:
        return float(time[0]) if len(above) else np.nan
    k = above[0]
    part = (level - turn[k - 1]) / (turn[k] - turn[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def _along(motion: MeasuredMotion, markers: Planar) -> Array:
    """How far the middle of markers is displaced in the direction in which it settles, of that distance, (T,)."""
    away = np.mean(markers - motion.reference, axis=1)
    rests = complex(settled(motion.time, away, motion.end))
    along: Array = (away * np.conj(rests)).real / abs(rests) ** 2
    return along


def _swing(time: Array, along: Array, end: float) -> tuple[float, float]:
    """Frequency, Hz, and logarithmic decrement of the swings about what settles."""
    swing = np.nan_to_num(along[(time >= 0) & (time <= end)] - 1)
    peaks = find_peaks(swing, prominence=_CLEAR, height=_CLEAR)[0][:_PEAKS]
    if len(peaks) < 3:
        return np.nan, np.nan
    refined = [_vertex(swing[k - 1 : k + 2]) for k in peaks]
    moments = (peaks + np.array([shift for shift, _ in refined])) * np.median(np.diff(time))
    numbers, heights = np.arange(len(peaks)), np.log([height for _, height in refined])
    return 1 / float(np.polyfit(numbers, moments, 1)[0]), -float(np.polyfit(numbers, heights, 1)[0])


def _vertex(three: Array) -> tuple[float, float]:
    """Of the parabola through three samples: how many samples from the middle one it lies, and how high."""
    before, at, after = three
    curvature = before - 2 * at + after
    shift = 0.0 if curvature == 0 else 0.5 * (before - after) / curvature
    return float(shift), float(at - 0.25 * (before - after) * shift)
