"""How far an object slides on the fingers that hold it, from recorded states of the plant and its recorded poses."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.plant_finger import PlantFinger


class Grip(NamedTuple):
    """A point on a finger's link and a point on the object that coincide when the grip begins."""

    link: RigidBody
    on_link: Array  # (3,) m, in the frame of the link
    on_object: Array  # (3,) m, in the frame of the object


def slip(station: Station, recording: Recording, held: str, samples: NDArray[np.int_]) -> Array:
    """Slip of an object along the fingers since the first of some samples of a recording, (K,) m.

    It is the length of `shifts`, averaged over the touching fingers; NaN without contact at the first sample.
    """
    found = shifts(station, recording, held, samples)
    if not found.shape[1]:
        return np.full(len(found), np.nan)
    slips: Array = np.linalg.norm(found, axis=-1).mean(axis=1)
    return slips


def path_length(shifted: Array) -> float:
    """Length of the path along which an object slides, m, averaged over the fingers; NaN without any.

    A distance from the first place would hide that it slides back, such as by creep after the fingers have lifted it.

    Args:
        shifted: see `shifts`, (K, F, 2) m.
    """
    if not shifted.shape[1]:
        return np.nan
    return float(np.linalg.norm(np.diff(shifted, axis=0), axis=-1).sum(axis=0).mean())


def shifts(station: Station, recording: Recording, held: str, samples: NDArray[np.int_]) -> Array:
    """Shift of an object along each of the F touching fingers since the first of some samples, (K, F, 2) m.

    At the first sample, the true contact centre of each finger marks a point on the object and one on the nearest link.
    The shift leads from one to the other along the link's inner face (its y and z axes).
    """
    plant, states = station.plant, recording["plant.state"].values[samples]
    if not len(samples):
        return np.empty((0, 0, 2))
    poses, context = recorded_poses(recording, held, samples), plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, states[0])
    centers = {finger: recording[f"{finger.name}.contact_center"].values[samples[0]] for finger in station.fingers}
    grips = [grip_at(context, finger, poses[0], p_WC) for finger, p_WC in centers.items() if np.isfinite(p_WC).all()]
    found = np.empty((len(states), len(grips), 2))
    for i, state in enumerate(states if grips else ()):
        plant.SetPositionsAndVelocities(context, state)
        found[i] = [shift(context, grip, poses[i]) for grip in grips]
    return found


def recorded_poses(recording: Recording, name: str, samples: Sequence[int] | NDArray[np.int_]) -> list[RigidTransform]:
    """The poses of an object in the world at some samples of a recording."""
    poses = recording[f"{name}.pose"].values[samples]
    return [RigidTransform(Quaternion(pose[:4] / np.linalg.norm(pose[:4])), pose[4:]) for pose in poses]


def grip_at(context: Context, finger: PlantFinger, X_WO: RigidTransform, p_WC: Array) -> Grip:
    """The grip of a finger on an object at a point in the world, on the link with the nearest centre."""
    points = np.array([link.EvalPoseInWorld(context).inverse() @ p_WC for link in finger.links])
    middles = np.diff(finger.finger.link_ends) / 2
    nearest = int(np.argmin(np.linalg.norm(points - np.outer(middles, [0.0, 0.0, 1.0]), axis=1)))
    return Grip(finger.links[nearest], points[nearest], X_WO.inverse() @ p_WC)


def shift(context: Context, grip: Grip, X_WO: RigidTransform) -> Array:
    """Shift of the point of the object from that of the link, along the link's inner face, (2,) m."""
    X_LO = grip.link.EvalPoseInWorld(context).inverse() @ X_WO
    along: Array = (X_LO @ grip.on_object - grip.on_link)[1:]
    return along
