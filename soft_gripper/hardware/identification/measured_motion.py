"""What a recording says of a finger's tip: markers that are glued to it, seen in the bending plane."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.kinematics import as_planar
from soft_gripper.hardware.recordings.hardware_recording import HardwareRecording

_TIP = "tip"
_ABOVE_NOISE = 0.1  # of the largest displacement, which only an event brings about
_REACHED = 0.5  # of the largest displacement, which decides which rise and fall are the event's
_STILL_HELD = 0.97  # of the displacement before the valve closes
_LETTING_GO = 0.03  # s, that a hand is taken to need until a fit knows better
_LAST = 0.2  # s, over which what has settled is averaged


@dataclass(frozen=True)
class MeasuredMotion:
    """The markers of one recording, m, z + i x in B, and what made them move. NaN: not seen."""

    name: str
    time: Array  # (T,) s
    markers: Planar  # (T, M)
    reference: Planar  # (M,) mean of the markers before the event, when the finger is straight
    gravity: Array  # (3,) m/s^2, in B
    pressure: float | None  # Pa, in the chamber between two events; None: let go by a hand between two events
    load: TipLoad | None
    events: tuple[float, float]  # s, of a release, its begin and end; or of the valve, when it opens and closes

    @property
    def displacement(self) -> Array:
        """Mean distance of the markers from the reference, m, (T,)."""
        return np.abs(np.nanmean(self.markers - self.reference, axis=1))

    @property
    def largest(self) -> float:
        """Displacement, m."""
        return float(np.nanmax(self.displacement))

    @property
    def end(self) -> float:
        """When what has settled is over: the end of the recording, or the valve's closing, s."""
        return float(self.time[-1]) if self.pressure is None else self.events[1]

    def with_events(self, events: Array) -> "MeasuredMotion":
        """The same with other times of its events, s."""
        return MeasuredMotion(**{**self.__dict__, "events": tuple(map(float, events))})


def measured_motion(recording: HardwareRecording) -> MeasuredMotion:
    """Reads the motion of the tip from a recording.

    Raises:
        InputError: if the recording has no markers on the tip, or does not say what moves the finger, or nothing moves.
    """
    config = recording.config
    names = config.markers.bodies.get(_TIP, []) if config.markers else []
    if len(names) < 2:
        expected = "name two markers at least that are glued to the tip: they show how far it turns"
        raise InputError(recording.name, "markers.bodies.tip", names, expected)
    if config.event not in ("release", "step"):
        raise InputError(recording.name, "event", config.event, 'say what moves the finger: "release" or "step"')
    if config.event == "step" and recording.commanded_pressure is None:
        expected = "the file's name does not say the pressure in the way that commanded_pressure describes"
        raise InputError(recording.name, "commanded_pressure", None, expected)
    markers = as_planar(np.stack([recording.markers[name][:, [0, 2]] for name in names], axis=1))
    reference = as_planar(np.stack([recording.reference[name][[0, 2]] for name in names]))
    away = np.abs(np.nanmean(markers - reference, axis=1))
    events = _release(recording, away) if config.event == "release" else _steps(recording, away)
    gravity = np.zeros(3) if recording.gravity is None else recording.gravity
    pressure = recording.commanded_pressure if config.event == "step" else None
    return MeasuredMotion(
        recording.name, recording.time, markers, reference, gravity, pressure, _load(recording), events
    )


def _load(recording: HardwareRecording) -> TipLoad | None:
    if recording.load_mass == 0:
        return None
    x, z = recording.load_place or (0.0, 0.0)
    return TipLoad(recording.load_mass, x, z)


def _release(recording: HardwareRecording, away: Array) -> tuple[float, float]:
    """When the finger begins to move, and when the hand has let go; of the second nothing is seen."""
    begin = _begin(recording, away)
    return begin, begin + _LETTING_GO


def _steps(recording: HardwareRecording, away: Array) -> tuple[float, float]:
    """When the finger begins to move, and when it begins to move back."""
    begin, far = _begin(recording, away), np.flatnonzero(away > _REACHED * np.nanmax(away))
    if far[-1] >= len(away) - 2:
        raise InputError(recording.name, "event", "step", "the valve does not close before the recording ends")
    k = int(far[-1])
    held = np.nanmean(
        away[(recording.time > recording.time[k] - 2 * _LAST) & (recording.time < recording.time[k] - _LAST)]
    )
    while k > 0 and not away[k] > _STILL_HELD * held:
        k -= 1
    return begin, float(recording.time[k])


def _begin(recording: HardwareRecording, away: Array) -> float:
    before = recording.time < recording.time[0] + recording.config.reference
    if not np.nanmax(away) > 5 * np.nanmax(away[before]):
        expected = "the tip hardly moves more than before the event; is this the right description of the file?"
        raise InputError(recording.name, "markers", f"{1e3 * np.nanmax(away):.2g} mm", expected)
    k = int(np.flatnonzero(away > _REACHED * np.nanmax(away))[0])
    while k > 0 and not away[k] < _ABOVE_NOISE * np.nanmax(away):
        k -= 1
    return float(recording.time[k])


def turned(markers: Planar, reference: Planar) -> Array:
    """How far markers have turned from the reference in the bending plane, (..., M) -> (...) rad.

    The angle of the rotation that moves the one nearest to the other, by least squares.
    """
    centred = markers - markers.mean(axis=-1, keepdims=True)
    angle: Array = np.angle((centred * np.conj(reference - reference.mean())).sum(axis=-1))
    return angle


def settled(time: Array, values: NDArray[Any], end: float) -> Any:
    """Mean over the last moments before `end`, s, of values (T, ...)."""
    mean = np.nanmean(values[(time > end - _LAST) & (time <= end)], axis=0)
    return mean
