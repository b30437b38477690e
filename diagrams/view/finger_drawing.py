"""Drawing an estimated finger: points, frames of links, and the force, computed once for every back end.

Meshcat draws a sample of it, Foxglove a recording, and figures what they need; so leading axes are free. The corners of
a finger are its base, N joints and tip, (..., N + 2, 3) m in B. Links are straight from corner to corner, without
their twist.
"""

from collections.abc import Collection, Mapping
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import Arcs, join_arcs
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import AXES
from soft_gripper.fingers.kinematics import as_planar, in_space
from soft_gripper.sensors.sensor_block import joints_port
from soft_gripper.truth.poses import corners

LENGTH = 0.025  # m/N, of the arrow of a force
MIN_FORCE = 0.02  # N, smallest that is drawn
# Signals with joints and tip, and with the contact, in space and in the bending plane.
SHAPES = ("estimated_joint_positions", "estimated_tip_position"), ("joint_positions", "tip_pose")
CONTACTS = ("contact_force_vector", "contact_arc_length", "contact_side"), ("contact_force", "contact_arc_length")
BAND_SIGNAL = "position_std"
STDS = 2  # standard deviations on either side of a band
_MIN_SINE = 1e-6  # of the angle between a vector and the y of B, below which x is that of B


def drawn_signals(signals: Collection[str]) -> list[str]:
    """Chooses the signals from which a finger is drawn, with contact and band; none without a shape.

    A finger that only bends is drawn in its plane, where its curve is one of arcs.
    """
    other_names = {f"estimated_{joints_port(deformation)}" for deformation in AXES if deformation != "bending"}
    first = 0 if other_names & {*signals} else 1
    shape, contact = (
        next((names for names in choices[first:] if {*names} <= {*signals}), ()) for choices in (SHAPES, CONTACTS)
    )
    return [*shape, *contact, *[BAND_SIGNAL] * (BAND_SIGNAL in signals)] if shape else []


def is_in_space(signals: Collection[str]) -> bool:
    """Whether the signals describe a shape in space, not in the bending plane."""
    return {*SHAPES[0]} <= {*signals}


def estimated_corners(signals: Mapping[str, Array]) -> Array:
    """Corners of the shape among signals by name, a sample or more of each."""
    joints, tip = (signals[name] for name in SHAPES[0 if is_in_space(signals) else 1])
    if is_in_space(signals):
        return corners(joints.reshape(*tip.shape[:-1], -1, 3), tip)
    planar = joints.reshape(*tip.shape[:-1], -1, 2), tip[..., :2]
    return corners(*(in_space(as_planar(points)) for points in planar))


class Contact(NamedTuple):
    """An estimated contact force; NaN where it is not known."""

    force: Array  # (..., 3) N in B
    arc_length: Array  # (...) m
    side: Array  # (...) rad around the section, 0 on the inner side, as `ContactForce.side`


def estimated_contact(signals: Mapping[str, Array], corners: Array) -> Contact | None:
    """The contact of signals by name; None if it is not among them."""
    lead = corners.shape[:-2]
    has_space_force, has_plane_force = ({*names} <= signals.keys() for names in CONTACTS)
    if not has_space_force and not has_plane_force:
        return None
    s = signals["contact_arc_length"].reshape(lead)
    if has_space_force:
        return Contact(signals["contact_force_vector"].reshape(*lead, 3), s, signals["contact_side"].reshape(lead))
    force = signals["contact_force"].reshape(lead)
    inward = points_on_links(corners, s)[1][..., 0]
    return Contact(-force[..., None] * inward, s, np.where(force < 0, np.pi, 0.0))


def link_frames(corners: Array) -> Array:
    """Rotations in B, (..., N + 1, 3, 3), of the links: in the bending plane, x points inward; NaN if unknown."""
    return frames_along(np.diff(corners, axis=-2))


def frames_along(vectors: Array) -> Array:
    """Rotations in B, (..., 3, 3): z along vectors, (..., 3), and y as near to the y of B as possible."""
    z = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    x = np.cross([0.0, 1.0, 0.0], z)
    size = np.linalg.norm(x, axis=-1, keepdims=True)
    x = np.where(size < _MIN_SINE, [1.0, 0.0, 0.0], x / np.maximum(size, _MIN_SINE))
    return np.stack([x, np.cross(z, x), z], axis=-1)


def points_on_links(corners: Array, s: Array) -> tuple[Array, Array]:
    """Points at arc lengths (...) m along the links, (..., 3) m, and the frames there, (..., 3, 3); NaN if unknown."""
    steps = np.diff(corners, axis=-2)
    ends = np.linalg.norm(steps, axis=-1).cumsum(axis=-1)
    link = (np.asarray(s)[..., None] > ends[..., :-1]).sum(axis=-1)[..., None, None]
    begin, step = (np.take_along_axis(values, link, axis=-2)[..., 0, :] for values in (corners[..., :-1, :], steps))
    length = np.linalg.norm(step, axis=-1)
    end = np.take_along_axis(ends, link[..., 0], axis=-1)[..., 0]
    points = begin + ((s - end) / length + 1)[..., None] * step
    return points, np.take_along_axis(link_frames(corners), link[..., None], axis=-3)[..., 0, :, :]


def pressed_point(finger: Finger, corners: Array, s: float, side: float) -> Array:
    """Surface point of a finger at an arc length s, m, and an angle around the section, rad: (3) m in B."""
    section = finger.section(s)
    half = np.array([section.inner_face - section.outer_face, section.width]) / 2
    toward = np.array([np.cos(side), np.sin(side)])
    to_face = toward * np.min(half / np.maximum(np.abs(toward), 1e-9))
    to_face[0] += (section.inner_face + section.outer_face) / 2
    point, frame = points_on_links(corners, np.asarray(s))
    return np.asarray(point + frame[:, :2] @ to_face)


def arrow(begin: Array, force: Array) -> Array | None:
    """The arrow of a force, (3) N, at a point, (3) m: from there to where it points, (2, 3) m.

    None if the force is below `MIN_FORCE`, or force or point are not known.
    """
    ends = np.array([begin, begin + LENGTH * force])
    return ends if np.isfinite(ends).all() and np.linalg.norm(force) >= MIN_FORCE else None


def contact_arrow(finger: Finger, corners: Array, contact: Contact | None) -> Array | None:
    """The arrow of a contact, (2, 3) m in B, from where the surface is pressed; None: none is drawn, see `arrow`."""
    if contact is None:
        return None
    return arrow(pressed_point(finger, corners, float(contact.arc_length), float(contact.side)), contact.force)


def to_world(X_WB: Array, points: Array) -> Array:
    """Converts points in B, (..., M, 3) m, to the world; X_WB is the pose of B, [R | p], (..., 3, 4)."""
    return points @ np.swapaxes(X_WB[..., :3], -1, -2) + X_WB[..., None, :, 3]


def force_in_world(signals: Mapping[str, Array], corners: Array) -> tuple[Array, Array] | None:
    """Location of the estimated contact force on the middle line of the links, (..., 3) m, and the force, (..., 3) N.

    Both in the world, by the `X_WB` (..., 3, 4) among the signals of a finger; None if no contact is estimated.
    """
    contact = estimated_contact(signals, corners)
    X_WB = signals["X_WB"]
    if contact is None:
        return None
    point = points_on_links(corners, contact.arc_length)[0]
    return to_world(X_WB, point[..., None, :])[..., 0, :], (X_WB[..., :3] @ contact.force[..., None])[..., 0]


def arcs_of_table(table: Array) -> Arcs:
    """The arcs in an `arcs` port of an estimator, (S, 7)."""
    _, _, _, kappa, length, _, _ = table.T
    return join_arcs(kappa * length, length)


def arc_frames(arcs: Arcs) -> tuple[Planar, Array, Array]:
    """Centres (m in B) of the arcs, headings (rad) of the radii to their starting points, and radii (m), each (S)."""
    headings = arcs.heading - np.sign(arcs.theta) * np.pi / 2
    return arcs.centers, headings, np.abs(arcs.start - arcs.centers)
