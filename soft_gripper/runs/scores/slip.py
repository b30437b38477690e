"""How far an object slides on the fingers that hold it, from recorded states of the plant and its recorded poses."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context
from scipy.spatial.transform import Rotation

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
    poses, context = pose_matrices(recording, held, samples), plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, states[0])
    centers = {finger: recording[f"{finger.name}.contact_center"].values[samples[0]] for finger in station.fingers}
    X_WO = RigidTransform(poses[0])
    grips = [grip_at(context, finger, X_WO, p_WC) for finger, p_WC in centers.items() if np.isfinite(p_WC).all()]
    X_WL = np.empty((len(states), len(grips), 3, 4))
    for i, state in enumerate(states if grips else ()):
        plant.SetPositionsAndVelocities(context, state)
        for j, grip in enumerate(grips):
            X_WL[i, j] = grip.link.EvalPoseInWorld(context).GetAsMatrix34()
    found = [_along(X_WL[:, j], poses, grip) for j, grip in enumerate(grips)]
    return np.stack(found, axis=1) if found else np.empty((len(states), 0, 2))


def _along(X_WL: Array, X_WO: Array, grip: Grip) -> Array:
    """Shifts of the point of the object from that of the link, along the link's inner face, (K, 2) m.

    `X_WL` and `X_WO` are the poses of link and object at K samples, (K, 3, 4).
    """
    p_WC = X_WO[..., :3] @ grip.on_object + X_WO[..., 3]
    p_LC = ((p_WC - X_WL[..., 3])[:, None] @ X_WL[..., :3])[:, 0]
    return np.asarray((p_LC - grip.on_link)[:, 1:])


def pose_matrices(recording: Recording, name: str, samples: Sequence[int] | NDArray[np.int_]) -> Array:
    """The poses of an object in the world at K samples of a recording, (K, 3, 4) [R | p]."""
    poses = recording[f"{name}.pose"].values[samples]
    rotations = Rotation.from_quat(poses[:, :4], scalar_first=True).as_matrix()
    return np.concatenate([rotations, poses[:, 4:, None]], axis=-1)


def recorded_poses(recording: Recording, name: str, samples: Sequence[int] | NDArray[np.int_]) -> list[RigidTransform]:
    """The poses of an object in the world at some samples of a recording."""
    return [*map(RigidTransform, pose_matrices(recording, name, samples))]


def grip_at(context: Context, finger: PlantFinger, X_WO: RigidTransform, p_WC: Array) -> Grip:
    """The grip of a finger on an object at a point in the world, on the link with the nearest centre."""
    nearest, on_link = nearest_link(finger, link_poses(context, finger), p_WC)
    return Grip(finger.links[int(nearest)], on_link, X_WO.inverse() @ p_WC)


def link_poses(context: Context, finger: PlantFinger) -> Array:
    """Poses of the L links of a finger in the world, (L, 3, 4) [R | p]."""
    return np.array([link.EvalPoseInWorld(context).GetAsMatrix34() for link in finger.links])


def nearest_link(finger: PlantFinger, X_WL: Array, p_WC: Array) -> tuple[NDArray[np.int_], Array]:
    """The number of the link whose centre is nearest to a point, (...), and the point in its frame, (..., 3) m.

    `X_WL` are the poses of all links, (..., L, 3, 4), and `p_WC` the point in the world, (..., 3) m.
    """
    points = ((p_WC[..., None, :] - X_WL[..., 3])[..., None, :] @ X_WL[..., :3])[..., 0, :]
    middles = np.diff(finger.finger.link_ends) / 2
    nearest = np.argmin(np.linalg.norm(points - np.outer(middles, [0.0, 0.0, 1.0]), axis=-1), axis=-1)
    return nearest, np.take_along_axis(points, nearest[..., None, None], axis=-2)[..., 0, :]


def shift(context: Context, grip: Grip, X_WO: RigidTransform) -> Array:
    """Shift of the point of the object from that of the link, along the link's inner face, (2,) m."""
    X_WL = grip.link.EvalPoseInWorld(context).GetAsMatrix34()
    found: Array = _along(X_WL[None], X_WO.GetAsMatrix34()[None], grip)[0]
    return found
