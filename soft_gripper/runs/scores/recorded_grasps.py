"""The grasp of every free object in a recording, see `grasp`."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.estimate import CLOSING
from soft_gripper.files.notes import READ, note
from soft_gripper.runs.scores.grasp import (
    FingerGrip,
    Grasp,
    Sizes,
    finger_grips,
    held_since,
    judge,
    last,
    pump_energy,
    stiffness,
)
from soft_gripper.runs.scores.recorded_object import NORMAL, RecordedObject
from soft_gripper.truth.contact import TOUCH

_MIN_WIDTH = 5e-3  # m, of an object: between fingers that touch each other or a table there is less


@dataclass(frozen=True)
class OfObject:
    """The object that a row belongs to."""

    object: str


@dataclass(frozen=True)
class ObjectGrip(FingerGrip, OfObject):
    """Grip of one finger on a named object."""


@dataclass(frozen=True)
class ObjectGrasp(Grasp, OfObject):
    """The grasp of an object."""


def objects_of(station: Station) -> list[str]:
    """The free models of a scenario whose grasp is recorded; the task's object comes first."""
    task = station.scenario.task
    names = [model.name for model in station.scenario.models if model.free]
    recorded = [name for name in names if f"{name}.{NORMAL}" in station.logs.signals]
    return sorted(recorded, key=lambda name: task is None or name != task.object)


def recorded_grasps(station: Station, recording: Recording) -> tuple[list[ObjectGrasp], list[ObjectGrip]]:
    """A row for each object, and a row for each object and finger."""
    grasps, grips = [], []
    for name in objects_of(station):
        grasp, of_fingers = recorded_grasp(RecordedObject(station, recording, name))
        grasps.append(ObjectGrasp(name, **vars(grasp)))
        grips += [ObjectGrip(name, **vars(grip)) for grip in of_fingers]
    return grasps, grips


def touched_instead(station: Station, recording: Recording) -> str:
    """Bodies that fingers touch and that are no free objects, as a phrase; "" if there are none.

    It has a name if only one other body can be touched: forces are recorded of fingers, and of fingers on objects.
    """
    forces = {finger.name: _force_on_others(station, recording, i) for i, finger in enumerate(station.fingers)}
    touch_forces = {name: force for name, force in forces.items() if force > TOUCH}
    if not touch_forces:
        return ""
    names = _welded(station)
    touched_name = names[0] if len(names) == 1 else "something else"
    verb = "touches" if len(touch_forces) == 1 else "touch"
    return f"{' and '.join(touch_forces)} {verb} {touched_name}, with up to {max(touch_forces.values()):.2f} N"


def note_welded_object(station: Station, recording: Recording) -> None:
    """Notes that the fingers hold a model that is welded, and so has no grasp, if nothing is free."""
    width = _width(recording, "grip.true_object_width", np.arange(recording.data.sizes["time"]))
    if objects_of(station) or not (width > _MIN_WIDTH).any():
        return
    element = " or ".join(f"models.{name}.free" for name in _welded(station))
    note(READ, "scenario", element, False, "the fingers hold it, but only a free model has a grasp")


def _welded(station: Station) -> list[str]:
    """The models that are not free, without the arm and those with fingers."""
    arm = station.scenario.arm
    own_models = {finger.model_name for finger in station.fingers} | ({arm.model} if arm else set())
    return [model.name for model in station.scenario.models if not model.free and model.name not in own_models]


def _force_on_others(station: Station, recording: Recording, finger: int) -> float:
    """Largest normal force of a finger on bodies other than free objects, N."""
    total = recording.values(f"{station.fingers[finger].name}.normal_force")
    object_forces = [recording.values(f"{name}.{NORMAL}")[:, finger] for name in objects_of(station)]
    return float(np.nan_to_num(total - np.sum(object_forces, axis=0)).max(initial=0.0))


def recorded_grasp(item: RecordedObject) -> tuple[Grasp, list[FingerGrip]]:
    """The grasp of one object, and how each finger takes part in it."""
    samples, signals = item.samples, item.signals
    grips = finger_grips(signals, [finger.name for finger in item.station.fingers])
    begin, window = held_since(signals), np.flatnonzero(last(signals.time))
    slid_length = path_length(item.shifts(samples[begin:]))
    elapsed = signals.time[-1] - signals.time[window[0]]
    speed = float(item.slip(samples[window])[-1]) / elapsed if elapsed > 0 else np.nan
    return judge(signals, grips, slid_length, speed, _sizes(item), _energy(item)), grips


def path_length(shifts: Array) -> float:
    """Length of the path of `RecordedObject.shifts`, (K, F, 2) m, averaged over the fingers, m; NaN without any.

    A distance from the first place would hide that it slides back, such as by creep after the fingers have lifted it.
    """
    if not shifts.shape[1]:
        return np.nan
    return float(np.linalg.norm(np.diff(shifts, axis=0), axis=-1).sum(axis=0).mean())


def _sizes(item: RecordedObject) -> Sizes:
    """True width at the end, and stiffness as estimated, as far as they are recorded."""
    recording, samples = item.recording, item.samples
    true, estimated = (_width(recording, f"grip.{name}", samples) for name in ("true_object_width", "object_width"))
    forces = [f"{finger.name}.contact_force_vector" for finger in item.station.fingers]
    if not all(name in recording for name in forces):
        return Sizes(true[-1])
    force = np.mean([recording.values(name)[samples] @ CLOSING for name in forces], axis=0)
    return Sizes(true[-1], stiffness(estimated, force))


def _width(recording: Recording, signal: str, samples: NDArray[np.int_]) -> Array:
    """A width over some samples, (T) m; NaN if it was not recorded."""
    if signal not in recording:
        return np.full(len(samples), np.nan)
    return recording.values(signal)[samples].ravel()


def _energy(item: RecordedObject) -> float:
    """Work of the pump on all fingers, J; the volume of a chamber grows with the joint angles.

    By virtual work, a chamber whose pressure p drives a joint by the torque g p grows by g per angle.
    """
    end, energy = item.samples[-1] + 1, 0.0
    state = item.recording.values("plant.state")[:end]
    for finger in item.station.fingers:
        if not finger.finger.pressures:
            continue
        pressure = item.recording.values(f"{finger.name}.pressure")[:end].reshape(end, -1)
        gains = finger.finger.pressure_gains
        growth = [state @ finger.position_selector(way).T @ gains[way].T for way in finger.finger.driven_deformations]
        energy += pump_energy(pressure, np.sum(growth, axis=0))
    return energy
