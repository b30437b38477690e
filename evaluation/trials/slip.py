"""Slip: how far a held object moves along the fingers that hold it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.scene.placing import first_body
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.plant_finger import PlantFinger


class Grip(NamedTuple):
    """A point of a finger's link and a point of the object that coincide when the grip begins."""

    link: RigidBody
    on_link: Array  # (3,) m, in the frame of the link
    on_object: Array  # (3,) m, in the frame of the object


def slip(station: Station, recording: Recording, samples: NDArray[np.int_]) -> float:
    """How far the object of the task moves along the fingers over some samples of a recording, m.

    At the first sample the true centre of contact of each finger marks a point of the object and one of the nearest
    link. Slip is the distance between the two along the link's inner face, its y and z axes, the mean over the
    fingers that touch, and the largest over the samples. NaN without samples or contact at the first.
    """
    plant, states = station.plant, recording["plant.state"].values[samples]
    if not len(samples):
        return float("nan")
    assert station.scenario.task is not None
    held = first_body(plant, str(station.scenario.task.object))
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, states[0])
    centers = {finger: recording[f"{finger.name}.contact_center"].values[samples[0]] for finger in station.fingers}
    grips = [_grip(context, finger, held, p_WC) for finger, p_WC in centers.items() if np.isfinite(p_WC).all()]
    if not grips:
        return float("nan")
    slips = np.empty((len(states), len(grips)))
    for slips_now, state in zip(slips, states, strict=True):
        plant.SetPositionsAndVelocities(context, state)
        slips_now[:] = [_moved(context, grip, held) for grip in grips]
    return float(slips.mean(axis=1).max())


def _grip(context: Context, finger: PlantFinger, held: RigidBody, p_WC: Array) -> Grip:
    """The grip at a point in the world, of the link whose middle is nearest."""
    points = np.array([_in_frame(context, link, p_WC) for link in finger.links])
    middles = np.diff(finger.finger.link_ends) / 2
    nearest = int(np.argmin(np.linalg.norm(points - np.outer(middles, [0.0, 0.0, 1.0]), axis=1)))
    return Grip(finger.links[nearest], points[nearest], _in_frame(context, held, p_WC))


def _in_frame(context: Context, body: RigidBody, p_W: Array) -> Array:
    p_B: Array = body.EvalPoseInWorld(context).inverse() @ p_W
    return p_B


def _moved(context: Context, grip: Grip, held: RigidBody) -> float:
    """Distance of the object's point from the link's, along the link's inner face, m."""
    X_LO = held.body_frame().CalcPose(context, grip.link.body_frame())
    _, y, z = X_LO @ grip.on_object - grip.on_link
    return float(np.hypot(y, z))
