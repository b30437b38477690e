"""Why the object of a recording slips, see `slipping`."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import first_body
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.spatial_chain import vector_product
from soft_gripper.runs.scores.grasp import NAN, GraspSignals, slip_ratio
from soft_gripper.runs.scores.recorded_grasps import (
    OfObject,
    RecordedObject,
    finger_friction,
    objects_of,
)
from soft_gripper.runs.scores.slip import base_poses, nearest_link, pose_matrices, seen_from
from soft_gripper.runs.scores.slipping import (
    RESTS,
    WILL_HOLD,
    WILL_SLIP,
    Slip,
    before,
    has_settled,
    held_span,
    object_friction,
    sliding_since,
    weight_share,
)


@dataclass(frozen=True)
class ObjectSlip(Slip, OfObject):
    """Why an object slips."""


def recorded_slips(station: Station, recording: Recording) -> list[ObjectSlip]:
    """A row for each object."""
    objects = [RecordedObject(station, recording, name) for name in objects_of(station)]
    return [ObjectSlip(each.name, **vars(recorded_slip(each))) for each in objects]


def recorded_slip(of: RecordedObject) -> Slip:
    """Why an object slips, and whether that could be known before it was lifted."""
    station, recording, held, samples, signals = of.station, of.recording, of.name, of.samples, of.signals
    span = held_span(signals.time, signals.normal.sum(axis=1))
    if span is None:
        return Slip()
    begin, end = span
    found = _predicted(station, recording, signals, samples, begin)
    lost = float(signals.time[end]) if end < len(samples) else NAN
    slides = _sliding(station, recording, held, samples[:end], begin)
    if slides is None:
        return replace(found, lost_s=lost)
    since, on = slides
    normal, friction = (each[before(signals.time, since)].mean(axis=0) for each in (signals.normal, signals.friction))
    share, names = weight_share(normal, signals.coefficients, signals.weight), [each.name for each in station.fingers]
    weakest = int(np.argmin(signals.coefficients))
    present, force = float(signals.coefficients[weakest]), float(normal.mean())
    of_finger = finger_friction(station, station.fingers[weakest])
    return replace(
        found,
        slips_s=float(signals.time[since]),
        slips_in=_phase(station, recording, int(samples[since])),
        slips_on=" and ".join(name for name, slips in zip(names, on, strict=True) if slips),
        lost_s=lost,
        used_share=slip_ratio(normal, friction, signals.coefficients),
        present_friction=present,
        least_friction=share * present,
        least_object_friction=object_friction(share * present, of_finger),
        present_force_n=force,
        needed_force_n=share * force,
    )


def _sliding(
    station: Station, recording: Recording, held: str, samples: NDArray[np.int_], begin: int
) -> tuple[int, NDArray[np.bool_]] | None:
    """`sliding_since` from `begin` to the last of some samples; it looks back only as far as the object slides."""
    time, reach = recording.values("time")[samples], 2 * RESTS
    while True:
        first = max(begin, int(np.searchsorted(time, time[-1] - reach)))
        found = sliding_since(time[first:], sliding_speeds(station, recording, held, samples[first:]))
        if found is None:
            return None
        since = first + found[0]
        if first == begin or time[since] - time[first] > RESTS:
            return since, found[1]
        reach *= 2


def _predicted(
    station: Station, recording: Recording, signals: GraspSignals, samples: NDArray[np.int_], touch: int
) -> Slip:
    """The prediction from the forces before an object is lifted.

    They are those at the end of the phase before the first that holds it; without phases that hold it,
    those at the end of the phase of the first touch.
    """
    if station.task is None:
        return Slip()
    numbers = recording.values("task.phase").ravel()[samples]
    holds = [number for number, phase in enumerate(station.task.phases) if phase.holds]
    lifts = np.flatnonzero(np.isin(numbers, holds) if holds else numbers > numbers[touch])
    if not len(lifts) or lifts[0] <= touch:
        return Slip()
    normal = signals.normal[before(signals.time, int(lifts[0]))]
    if not has_settled(normal @ signals.coefficients):
        return Slip()
    share = weight_share(normal.mean(axis=0), signals.coefficients, signals.weight)
    return Slip(WILL_HOLD if share < 1 else WILL_SLIP, share)


def _phase(station: Station, recording: Recording, sample: int) -> str:
    """The name of the phase of a sample; "" without a task, and after its end."""
    if station.task is None:
        return ""
    number = int(recording.values("task.phase").ravel()[sample])
    return station.task.phases[number].name if number < len(station.task.phases) else ""


def sliding_speeds(station: Station, recording: Recording, held: str, samples: NDArray[np.int_]) -> Array:
    """Speed at which a rigid object slides along each finger, (K, F) m/s; NaN where they do not touch.

    It is that of the object relative to the nearest link, at the true centre of contact. In all directions: where the
    edge of a tip touches, the object does not slide along the link's inner face.
    """
    plant, fingers = station.plant, station.fingers
    if held in station.parts.deformables:
        return np.full((len(samples), len(fingers)), np.nan)
    p_WC = np.stack([recording.values(f"{finger.name}.contact_center")[samples] for finger in fingers], axis=1)
    touches = np.isfinite(p_WC).all(axis=-1)
    body, states, context = (
        first_body(plant, held),
        recording.values("plant.state")[samples],
        plant.CreateDefaultContext(),
    )
    nearest, p_WL = np.zeros(touches.shape, int), np.empty_like(p_WC)
    for j, X_WB in enumerate(base_poses(recording, fingers, samples)):
        X_BL = fingers[j].screws.poses(states)[:, :-1]
        nearest[:, j], _ = nearest_link(fingers[j], X_BL, seen_from(X_WB, p_WC[:, j]))
        p_BL = X_BL[np.arange(len(samples)), nearest[:, j], :, 3]
        p_WL[:, j] = (X_WB[..., :3] @ p_BL[..., None])[..., 0] + X_WB[..., 3]
    V = np.full((2, *touches.shape, 6), np.nan)
    for i in np.flatnonzero(touches.any(axis=1)):
        plant.SetPositionsAndVelocities(context, states[i])
        V[0, i] = body.EvalSpatialVelocityInWorld(context).get_coeffs()
        for finger in np.flatnonzero(touches[i]):
            link = fingers[finger].links[nearest[i, finger]]
            V[1, i, finger] = link.EvalSpatialVelocityInWorld(context).get_coeffs()
    p_WO = pose_matrices(recording, held, samples)[:, None, :, 3]
    return np.asarray(np.linalg.norm(_at(V[0], p_WC - p_WO) - _at(V[1], p_WC - p_WL), axis=-1))


def _at(V: Array, p: Array) -> Array:
    """Velocities at points, (..., 3) m/s, from spatial velocities [angular, linear] at origins p away, (..., 6)."""
    return np.asarray(V[..., 3:] + vector_product(V[..., :3], p))
