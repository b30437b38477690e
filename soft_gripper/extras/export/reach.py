"""Finds shapes that can never touch a fixed one, however the joints of their bodies move."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.geometry import Box, Capsule, Cylinder, HalfSpace, Shape, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Joint, PrismaticJoint, RevoluteJoint, WeldJoint

from soft_gripper.arrays import Array

_REACH_MARGIN = 0.01  # m; MuJoCo's limits of joints are soft


class Ball(NamedTuple):
    """A ball, m, that the origin of a body never leaves."""

    center: Array  # (3,) m in the world
    radius: float  # m; infinite for a free body, 0 for one that is fixed


def reaches(plant: MultibodyPlant, children: Mapping[BodyIndex, Sequence[Joint]]) -> dict[BodyIndex, Ball]:
    """Balls that the origins of all bodies never leave; `children` are the joints below each body."""
    world = plant.world_body()
    balls = {world.index(): Ball(np.zeros(3), 0.0)}
    pending_bodies = [world]
    context = plant.CreateDefaultContext()
    while pending_bodies:
        parent = pending_bodies.pop()
        for joint in children.get(parent.index(), ()):
            body = joint.child_body()
            pivot = joint.frame_on_parent()
            center, radius = balls[parent.index()]
            if plant.IsAnchored(parent):
                center = pivot.CalcPoseInWorld(context).translation()
            else:
                radius += _offset_length(pivot.GetFixedPoseInBodyFrame())
            radius += _travel(joint) + _offset_length(joint.frame_on_child().GetFixedPoseInBodyFrame())
            if plant.IsAnchored(body):
                center, radius = body.EvalPoseInWorld(context).translation(), 0.0
            balls[body.index()] = Ball(center, radius)
            pending_bodies.append(body)
    return balls


def _offset_length(X: RigidTransform) -> float:
    return float(np.linalg.norm(X.translation()))


def _travel(joint: Joint) -> float:
    """Largest travel of the origin of a joint's frame, m."""
    if isinstance(joint, RevoluteJoint | WeldJoint):
        return 0.0
    if isinstance(joint, PrismaticJoint):
        return float(max(abs(joint.position_lower_limit()), abs(joint.position_upper_limit())))
    return np.inf


def extent(shape: Shape, X_BG: RigidTransform) -> float:
    """Distance of the farthest point of a shape from the origin of its body, m, at most."""
    return _offset_length(X_BG) + _shape_radius(shape)


def _shape_radius(shape: Shape) -> float:
    if isinstance(shape, Sphere):
        return float(shape.radius())
    if isinstance(shape, Box):
        return float(np.linalg.norm(shape.size()) / 2)
    if isinstance(shape, Capsule):
        return float(shape.radius() + shape.length() / 2)
    if isinstance(shape, Cylinder):
        return float(np.hypot(shape.radius(), shape.length() / 2))
    return np.inf


class ShapeRange(NamedTuple):
    """The range of places of a shape."""

    ball: Ball  # it stays inside
    shape: Shape
    X_WG: RigidTransform | None  # its pose, if it is fixed


def may_touch(first: ShapeRange, second: ShapeRange) -> bool:
    """Whether two shapes can touch; True if both move, as this is unknown."""
    return not (_stays_clear(first, second) or _stays_clear(second, first))


def _stays_clear(reach: ShapeRange, fixed_shape: ShapeRange) -> bool:
    """Whether a shape can never touch a fixed shape."""
    if fixed_shape.X_WG is None:
        return False
    center = fixed_shape.X_WG.inverse() @ reach.ball.center
    return _distance(fixed_shape.shape, center) > reach.ball.radius + _REACH_MARGIN


def _distance(shape: Shape, p_GQ: Array) -> float:
    """Distance of a point from a box or a half space, m; 0 from other shapes."""
    if isinstance(shape, HalfSpace):
        return float(p_GQ[2])
    if isinstance(shape, Box):
        return float(np.linalg.norm(np.maximum(np.abs(p_GQ) - shape.size() / 2, 0.0)))
    return 0.0
