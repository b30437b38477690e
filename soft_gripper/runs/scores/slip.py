"""How far an object slides on the fingers that hold it, from recorded states of the plant and its recorded poses."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
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
    if not len(samples):
        return np.empty((0, 0, 2))
    states, X_WO = recording.values("plant.state")[samples], pose_matrices(recording, held, samples)
    found = []
    for finger, X_WB in zip(station.fingers, base_poses(recording, station.fingers, samples), strict=True):
        p_WC = recording.values(f"{finger.name}.contact_center")[samples[0]]
        if np.isfinite(p_WC).all():
            X_BL = finger.screws.poses(states)[:, :-1]
            nearest, on_link = nearest_link(finger, X_BL[0], seen_from(X_WB[0], p_WC))
            on_object = (p_WC - X_WO[0, :, 3]) @ X_WO[0, :, :3]
            p_WC = X_WO[..., :3] @ on_object + X_WO[..., 3]
            found.append(_along(X_BL[:, nearest], seen_from(X_WB, p_WC), on_link))
    return np.stack(found, axis=1) if found else np.empty((len(samples), 0, 2))


def _along(X: Array, p: Array, on_link: Array) -> Array:
    """Shifts of a point of the object from that of a link, along the link's inner face, (..., 2) m.

    Args:
        X: the pose of the link in any frame, (..., 3, 4).
        p: the point of the object in it, (..., 3) m.
        on_link: the point of the link, in its own frame, (3,) m.
    """
    return np.asarray((seen_from(X, p) - on_link)[..., 1:])


def seen_from(X: Array, p: Array) -> Array:
    """Points seen from a frame whose pose is X, (..., 3, 4) [R | p] and (..., 3) m -> (..., 3) m."""
    return np.asarray(((p - X[..., 3])[..., None, :] @ X[..., :3])[..., 0, :])


def base_poses(
    recording: Recording, fingers: Sequence[PlantFinger], samples: Sequence[int] | NDArray[np.int_]
) -> Array:
    """Poses of the bases of F fingers in the world, (F, K, 3, 4) [R | p], or (F, 1, 3, 4) if they do not move."""
    if all(finger.is_anchored for finger in fingers):
        return np.array([[finger.X_WB.GetAsMatrix34()] for finger in fingers])
    plant, states = fingers[0].plant, recording.values("plant.state")[samples]
    context, found = plant.CreateDefaultContext(), np.empty((len(fingers), len(states), 3, 4))
    for i, state in enumerate(states):
        plant.SetPositionsAndVelocities(context, state)
        for j, finger in enumerate(fingers):
            found[j, i] = finger.base.EvalPoseInWorld(context).GetAsMatrix34()
    return found


def pose_matrices(recording: Recording, name: str, samples: Sequence[int] | NDArray[np.int_]) -> Array:
    """The poses of an object in the world at K samples of a recording, (K, 3, 4) [R | p]."""
    from scipy.spatial.transform import Rotation

    poses = recording.values(f"{name}.pose")[samples]
    rotations = Rotation.from_quat(poses[:, :4], scalar_first=True).as_matrix()
    return np.concatenate([rotations, poses[:, 4:, None]], axis=-1)


def recorded_poses(recording: Recording, name: str, samples: Sequence[int] | NDArray[np.int_]) -> list[RigidTransform]:
    """The poses of an object in the world at some samples of a recording."""
    return [*map(RigidTransform, pose_matrices(recording, name, samples))]


def grip_at(context: Context, finger: PlantFinger, X_WO: RigidTransform, p_WC: Array) -> Grip:
    """The grip of a finger on an object at a point in the world, on the link with the nearest centre."""
    X_WL = np.array([link.EvalPoseInWorld(context).GetAsMatrix34() for link in finger.links])
    nearest, on_link = nearest_link(finger, X_WL, p_WC)
    return Grip(finger.links[int(nearest)], on_link, X_WO.inverse() @ p_WC)


def nearest_link(finger: PlantFinger, X: Array, p: Array) -> tuple[NDArray[np.int_], Array]:
    """The number of the link whose centre is nearest to a point, (...), and the point in its frame, (..., 3) m.

    `X` are the poses of all links in any frame, (..., L, 3, 4), and `p` the point in it, (..., 3) m.
    """
    points = seen_from(X, p[..., None, :])
    middles = np.diff(finger.finger.link_ends) / 2
    nearest = np.argmin(np.linalg.norm(points - np.outer(middles, [0.0, 0.0, 1.0]), axis=-1), axis=-1)
    return nearest, np.take_along_axis(points, nearest[..., None, None], axis=-2)[..., 0, :]


def shift(context: Context, grip: Grip, X_WO: RigidTransform) -> Array:
    """Shift of the point of the object from that of the link, along the link's inner face, (2,) m."""
    return _along(grip.link.EvalPoseInWorld(context).GetAsMatrix34(), X_WO @ grip.on_object, grip.on_link)
