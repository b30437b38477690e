"""From where a scene is seen, in pictures and in Meshcat."""

from collections.abc import Iterable, Sequence
from itertools import product

import numpy as np
from pydrake.geometry import Role, SceneGraph
from pydrake.math import RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.scenario import ArmConfig

_ASIDE = np.radians(45.0)  # to the right of the arm, so that it is behind what it does, and not hidden by it
_DOWNWARD = 0.35  # for every metre forward, so that the height above the bench is seen
_CORNERS = np.array(list(product((-1, 1), repeat=3)))  # of a box, in halves of its widths


def viewing_direction(
    arm: ArmConfig | None, plant: MultibodyPlant, fingers: Sequence[PlantFinger], without_arm: Array
) -> Array:
    """The direction of sight into a scene, (3) in the world, of any length.

    An arm is seen from in front of it, aside and above; front is where it begins to hold the fingers.
    `without_arm` is the direction for fingers alone.
    """
    if arm is None:
        return without_arm
    foot = plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(arm.model))[0])
    p_WFoot = plant.EvalBodyPoseInWorld(plant.CreateDefaultContext(), foot).translation()
    ahead = np.mean([finger.X_WB.translation() for finger in fingers], axis=0) - p_WFoot
    turn = RotationMatrix.MakeZRotation(np.arctan2(ahead[1], ahead[0]) + _ASIDE)
    direction: Array = turn @ np.array([0.0, 1.0, -_DOWNWARD])
    return direction


def upright_view(direction: Array) -> RotationMatrix:
    """The axes in the world of an upright picture: x to the right, y down and z in `direction`."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(z, [0.0, 0.0, 1.0]) / np.hypot(z[0], z[1])
    return RotationMatrix(np.column_stack([x, np.cross(z, x), z]))


def nearest_eye(p_W: Array, R_WC: RotationMatrix, least: Array, most: Array) -> Array:
    """The nearest point from which all points, (M, 3) m, lie within the edges of a picture, (3) m.

    The axes of the picture are R_WC. Along them an eye at c sees a point p if, to the right and down, p - c is
    between `least`, (2), and `most`, (2), times the distance p_z - c_z.
    """
    along = p_W @ R_WC.matrix()
    lowest = np.max(along[:, :2] - most * along[:, 2:], axis=0)
    highest = np.min(along[:, :2] - least * along[:, 2:], axis=0)
    depth = np.min((highest - lowest) / (most - least))
    eye: Array = R_WC.matrix() @ [*(lowest + highest + (least + most) * depth) / 2, depth]
    return eye


def box_corners(
    plant: MultibodyPlant, scene_graph: SceneGraph, context: Context, models: Iterable[ModelInstanceIndex], role: Role
) -> Array:
    """Corners of the boxes around all shapes of a role that some models have, (M, 3) m in the world.

    `context` is the plant's.
    """
    inspector = scene_graph.model_inspector()
    corners = []
    for body in (plant.get_body(index) for model in models for index in plant.GetBodyIndices(model)):
        X_WBody = plant.EvalBodyPoseInWorld(context, body)
        for shape in inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()), role):
            box = inspector.GetObbInGeometryFrame(shape)
            X_WBox = X_WBody @ inspector.GetPoseInFrame(shape) @ box.pose()
            corners.append((X_WBox @ (_CORNERS * box.half_width()).T).T)
    return np.concatenate([np.empty((0, 3)), *corners])
