"""The grasp of every free object in a recording, see `grasp`."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import GeometryId

from soft_gripper.arrays import Array
from soft_gripper.control.task import Phase
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import first_body
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.estimate import CLOSING
from soft_gripper.files.notes import READ, note
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.grasp import (
    FingerGrip,
    Grasp,
    GraspSignals,
    Sizes,
    finger_grips,
    held_since,
    judge,
    last,
    pump_energy,
    stiffness,
)
from soft_gripper.runs.scores.slip import base_poses, path_length, pose_matrices, shifts, slip
from soft_gripper.truth.contact import TOUCH, combined_friction

NORMAL = "grip_normal_force"
_MIN_WIDTH = 5e-3  # m, of an object: between fingers that touch each other or a table there is less
_SIGNALS = (NORMAL, "grip_friction_force", "grip_force", "grip_area", "grip_pressure")


@dataclass(frozen=True)
class OfObject:
    """The object that a row belongs to."""

    object: str


@dataclass(frozen=True)
class ObjectGrip(FingerGrip, OfObject):
    """How one finger holds an object."""


@dataclass(frozen=True)
class ObjectGrasp(Grasp, OfObject):
    """The grasp of an object."""


@dataclass(frozen=True)
class RecordedObject:
    """An object in a recording, and the signals by which its grasp is judged, collected once."""

    station: Station
    recording: Recording
    name: str

    @cached_property
    def samples(self) -> NDArray[np.int_]:
        """See `judged_samples`."""
        return judged_samples(self.station, self.recording, self.name)

    @cached_property
    def signals(self) -> GraspSignals:
        """At these samples, see `grasp_signals`."""
        return grasp_signals(self.station, self.recording, self.name, self.samples)


def objects_of(station: Station) -> list[str]:
    """The free models of a scenario whose grasp is recorded; that of the task comes first."""
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
    touching = {name: force for name, force in forces.items() if force > TOUCH}
    if not touching:
        return ""
    names = _welded(station)
    what = names[0] if len(names) == 1 else "something else"
    verb = "touches" if len(touching) == 1 else "touch"
    return f"{' and '.join(touching)} {verb} {what}, with up to {max(touching.values()):.2f} N"


def note_welded_object(station: Station, recording: Recording) -> None:
    """Notes that the fingers hold a model that is welded, and so has no grasp, if nothing is free."""
    width = _width(recording, "grip.true_object_width", np.arange(recording.data.sizes["time"]))
    if objects_of(station) or not (width > _MIN_WIDTH).any():
        return
    element = " or ".join(f"models.{name}.free" for name in _welded(station))
    note(READ, "scenario", element, False, "the fingers hold it, but only a free model has a grasp")


def _welded(station: Station) -> list[str]:
    """The models that are not free, but for the arm and those with fingers."""
    arm = station.scenario.arm
    own = {finger.model_name for finger in station.fingers} | ({arm.model} if arm else set())
    return [model.name for model in station.scenario.models if not model.free and model.name not in own]


def _force_on_others(station: Station, recording: Recording, finger: int) -> float:
    """The largest normal force of a finger on what is no free object, N."""
    total = recording.values(f"{station.fingers[finger].name}.normal_force")
    on_objects = [recording.values(f"{name}.{NORMAL}")[:, finger] for name in objects_of(station)]
    return float(np.nan_to_num(total - np.sum(on_objects, axis=0)).max(initial=0.0))


def recorded_grasp(of: RecordedObject) -> tuple[Grasp, list[FingerGrip]]:
    """The grasp of one object, and how each finger takes part in it."""
    station, recording, held, samples, signals = of.station, of.recording, of.name, of.samples, of.signals
    grips = finger_grips(signals, [finger.name for finger in station.fingers])
    begin, window = held_since(signals), np.flatnonzero(last(signals.time))
    slid = path_length(shifts(station, recording, held, samples[begin:]))
    at_the_end = slip(station, recording, held, samples[window])
    elapsed = signals.time[-1] - signals.time[window[0]]
    speed = float(at_the_end[-1]) / elapsed if elapsed > 0 else np.nan
    sizes = _sizes(station, recording, samples)
    energy = _energy(station, recording, samples)
    return judge(signals, grips, slid, speed, sizes, energy), grips


def judged_samples(station: Station, recording: Recording, held: str) -> NDArray[np.int_]:
    """The samples of which contact is known; in a task, those of them that are `before_put_down`."""
    known = np.isfinite(recording.values(f"{held}.{NORMAL}")).all(axis=1)
    if station.task is not None:
        known &= before_put_down(recording.values("task.phase").ravel(), station.task.phases)
    return np.flatnonzero(known)


def before_put_down(numbers: Array, phases: Sequence[Phase]) -> NDArray[np.bool_]:
    """The samples up to the end of the last phase that carries an object, (T).

    The last of several phases that hold it puts it down if another phase follows, and does not count. Without phases
    that hold an object, or if none was reached, all samples count.

    Args:
        numbers: of the phase at each sample, (T).
        phases: of the task, and its rescues.
    """
    holding = [number for number, phase in enumerate(phases) if phase.holds]
    if len(holding) > 1 and phases[holding[-1]].follower < len(phases):
        holding.pop()
    carries = np.isin(numbers, holding)
    until: NDArray[np.bool_] = np.logical_or.accumulate(carries[::-1])[::-1]
    return until if carries.any() else ~until


def grasp_signals(station: Station, recording: Recording, held: str, samples: NDArray[np.int_]) -> GraspSignals:
    """The signals by which the grasp of an object is judged."""
    normal, friction, force, area, pressure = (recording.values(f"{held}.{name}")[samples] for name in _SIGNALS)
    gravity = np.array(station.plant.gravity_field().gravity_vector())
    pull = float(np.linalg.norm(gravity))
    others = recording.values(f"{held}.contact_wrench")[samples, 3:] - force.sum(axis=1)
    support = -others @ gravity / pull if pull > 0 else np.zeros(len(samples))
    place, turn = _poses(station, recording, held, samples)
    coefficients = [friction_coefficient(station, finger, held) for finger in station.fingers]
    time = recording.values("time")[samples]
    return GraspSignals(
        *(time, normal, friction, area, pressure, support, place, turn),
        *(_mass(station, held) * pull, np.array(coefficients)),
    )


def _mass(station: Station, held: str) -> float:
    if held in station.parts.deformables:
        return station.parts.deformables[held].mass
    if held in station.parts.masses:
        return station.parts.masses[held]
    plant = station.plant
    bodies = plant.GetBodyIndices(plant.GetModelInstanceByName(held))
    return float(sum(plant.get_body(index).default_mass() for index in bodies))


def _poses(station: Station, recording: Recording, held: str, samples: NDArray[np.int_]) -> tuple[Array, Array]:
    """Positions and rotations of an object in the base of the first finger, (T, 3) and (T, 3, 3)."""
    X_WO, X_WB = pose_matrices(recording, held, samples), base_poses(recording, station.fingers[:1], samples)[0]
    to_base = np.swapaxes(X_WB[..., :3], -1, -2)
    places = (to_base @ (X_WO[..., 3:] - X_WB[..., 3:]))[..., 0]
    return places, to_base @ X_WO[..., :3]


def friction_coefficient(station: Station, finger: PlantFinger, held: str) -> float:
    """Static coefficient of friction between a finger and an object, of the smoothest geometry of each."""
    of_object = station.parts.frictions.get(held, _static_friction(station, _touched(station, held)))
    return combined_friction(finger_friction(station, finger), of_object)


def finger_friction(station: Station, finger: PlantFinger) -> float:
    """Static coefficient of friction of a finger's smoothest geometry."""
    geometries = [each for link in finger.links for each in station.plant.GetCollisionGeometriesForBody(link)]
    return _static_friction(station, geometries)


def _touched(station: Station, held: str) -> list[GeometryId]:
    """The collision geometries of the first link of an object."""
    if held in station.parts.deformables:
        return [station.parts.deformables[held].geometry]
    return list(station.plant.GetCollisionGeometriesForBody(first_body(station.plant, held)))


def _static_friction(station: Station, geometries: Sequence[GeometryId]) -> float:
    """The least static coefficient of friction of collision geometries; 0 if there are none."""
    inspector = station.parts.scene_graph.model_inspector()
    properties = [each for each in map(inspector.GetProximityProperties, geometries) if each is not None]
    return min((each.GetProperty("material", "coulomb_friction").static_friction() for each in properties), default=0.0)


def _sizes(station: Station, recording: Recording, samples: NDArray[np.int_]) -> Sizes:
    """True width at the end, and stiffness as estimated, as far as they are recorded."""
    true, estimated = (_width(recording, f"grip.{name}", samples) for name in ("true_object_width", "object_width"))
    forces = [f"{finger.name}.contact_force_vector" for finger in station.fingers]
    if not all(name in recording for name in forces):
        return Sizes(true[-1])
    force = np.mean([recording.values(name)[samples] @ CLOSING for name in forces], axis=0)
    return Sizes(true[-1], stiffness(estimated, force))


def _width(recording: Recording, signal: str, samples: NDArray[np.int_]) -> Array:
    """A width over some samples, (T) m; NaN if it was not recorded."""
    if signal not in recording:
        return np.full(len(samples), np.nan)
    width: Array = recording.values(signal)[samples].ravel()
    return width


def _energy(station: Station, recording: Recording, samples: NDArray[np.int_]) -> float:
    """Work of the pump on all fingers, J; the volume of a chamber grows with the joints by what pressure drives them.

    By virtual work, a chamber whose pressure p drives a joint by the torque g p grows by g per angle.
    """
    until, energy = samples[-1] + 1, 0.0
    state = recording.values("plant.state")[:until]
    for finger in station.fingers:
        if not finger.finger.pressures:
            continue
        pressure = recording.values(f"{finger.name}.pressure")[:until].reshape(until, -1)
        gains = finger.finger.pressure_gains
        growth = [state @ finger.position_selector(way).T @ gains[way].T for way in finger.finger.driven_ways]
        energy += pump_energy(pressure, np.sum(growth, axis=0))
    return energy
