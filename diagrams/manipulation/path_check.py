"""No motion of a task leads through anything: all are checked before anything moves."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import PenetrationAsPointPair, SceneGraph, SceneGraphInspector
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame
from pydrake.systems.framework import Diagram

from soft_gripper.arrays import Array
from soft_gripper.control.task_phases import Phase
from soft_gripper.diagrams.manipulation.arm import Arm, carried_models
from soft_gripper.diagrams.scene import first_body, own_frame
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario import ModelConfig, TaskConfig

TOUCH_DEPTH = 1e-3  # m, depth of a touch


@dataclass(frozen=True)
class Collision:
    """A body of the robot inside something that is not of the robot."""

    index: int  # of the positions in which it happens
    body: str  # of the robot; names are model::body
    obstacle: str
    depth: float  # m

    def __str__(self) -> str:
        return f"'{self.body}' is {self.depth * 1e3:.1f} mm inside '{self.obstacle}'"


def first_collision(
    diagram: Diagram,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robot: Collection[BodyIndex],
    positions: Array,
    allowed: float = TOUCH_DEPTH,
) -> Collision | None:
    """Walks through positions of the whole plant, (K, nq), until the robot meets something.

    Meshes count as their convex hulls. What is welded to the same body, and what a model filters, never collides.

    Args:
        diagram: holds plant and scene_graph.
        plant: the plant.
        scene_graph: its geometry.
        robot: its bodies, what it carries among them; they may touch each other.
        positions: rad and m; no finer steps are looked at.
        allowed: depth that passes for a touch, m.

    Returns:
        The deepest collision of the first positions that have one.
    """
    root = diagram.CreateDefaultContext()
    context, scene_context = plant.GetMyMutableContextFromRoot(root), scene_graph.GetMyContextFromRoot(root)
    own = frozenset(robot)
    for index, q in enumerate(positions):
        plant.SetPositions(context, q)
        query = scene_graph.get_query_output_port().Eval(scene_context)
        for pair in sorted(query.ComputePointPairPenetration(), key=lambda pair: -pair.depth):
            bodies = _bodies(plant, query.inspector(), pair)
            if pair.depth > allowed and len(bodies & own) == 1:
                (body,), (obstacle,) = bodies & own, bodies - own
                return Collision(index, _name(plant, body), _name(plant, obstacle), pair.depth)
    return None


def _bodies(
    plant: MultibodyPlant, inspector: SceneGraphInspector, pair: PenetrationAsPointPair
) -> frozenset[BodyIndex]:
    frames = [inspector.GetFrameId(geometry) for geometry in (pair.id_A, pair.id_B)]
    return frozenset(plant.GetBodyFromFrameId(frame).index() for frame in frames)


def _name(plant: MultibodyPlant, body: BodyIndex) -> str:
    return str(plant.get_body(body).scoped_name())


def reported_pose(task: TaskConfig, models: Sequence[ModelConfig]) -> RigidTransform:
    """Reported pose of the first link of the task's object in the world: the true one and `pose_error`."""
    (X_WO,) = (model.X_PC.GetDeterministicValue() for model in models if model.name == task.object)
    error = task.pose_error
    shift = np.array([error.x, error.y, 0.0])
    turned = RotationMatrix.MakeZRotation(error.yaw) @ X_WO.rotation()
    return RigidTransform(turned, X_WO.translation() + shift)


POSTURE_SPACING = 0.02  # rad or m, that a joint moves at most between two postures that are checked
OUT_OF_THE_WAY = RigidTransform([0.0, 0.0, 1e3])


def check_paths(
    diagram: Diagram,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    models: Sequence[ModelConfig],
    arm: Arm,
    task: TaskConfig,
    phases: Sequence[Phase],
) -> None:
    """Checks arm, gripper and, while it is held, the object, all along the motions of a task.

    The fingers are straight. The object stands where it is reported, then lies in them as it is to be grasped; in a
    rescue nobody knows where it is.

    Raises:
        InputError: naming the phase, what meets what, and where.
    """
    names = [arm.name, *(model.name for model in carried_models(models, arm.name))]
    robot = {body for name in names for body in plant.GetBodyIndices(plant.GetModelInstanceByName(name))}
    tool = own_frame(plant, arm.tool_model, "models")
    for i, phase in enumerate(phases):
        postures = _postures(phase)
        positions = _positions(plant, arm, task, tool, postures, _place(models, task, i))
        held = {first_body(plant, task.object).index()} if phase.holds and task.object is not None else set()
        collision = first_collision(diagram, plant, scene_graph, robot | held, positions)
        if collision is not None:
            failed = next((k for k, other in enumerate(phases) if other.rescue in range(i - 2, i + 1)), i)
            where = f"task.phases[{failed if i >= len(task.phases) else i}]"
            part = collision.index / (len(postures) - 1)
            raise InputError(where, "name", phase.name, f"leads through something: {part:.0%} on its way {collision}")


def _postures(phase: Phase) -> Array:
    """Postures along the motion of a phase, about evenly spaced, (K, n)."""
    fine = phase.motion.vector_values(np.linspace(0.0, phase.duration, 500)).T
    travel = np.concatenate([[0.0], np.abs(np.diff(fine, axis=0)).max(axis=1).cumsum()])
    count = 2 + int(travel[-1] / POSTURE_SPACING)
    evenly = np.linspace(0.0, travel[-1], count)
    return np.array([np.interp(evenly, travel, joint) for joint in fine.T]).T


def _place(models: Sequence[ModelConfig], task: TaskConfig, number: int) -> RigidTransform | None:
    """Where the object lies in a phase, as far as is known; None: in the fingers."""
    configs = task.phases
    if number >= len(configs) or task.object is None:
        return OUT_OF_THE_WAY
    if configs[number].holds:
        return None
    if any(config.holds for config in configs[:number]):
        return task.X_WGoal.GetDeterministicValue()
    return reported_pose(task, models)


def _positions(
    plant: MultibodyPlant,
    arm: Arm,
    task: TaskConfig,
    tool: Frame,
    postures: Array,
    X_WO: RigidTransform | None,
) -> Array:
    """Positions of the whole plant at postures (K, n) of the arm, (K, nq)."""
    context = plant.CreateDefaultContext()
    X_GO = task.X_OG.GetDeterministicValue().inverse()
    positions = []
    for posture in postures:
        plant.SetPositions(context, arm.model, posture)
        if task.object is not None:
            pose = tool.CalcPoseInWorld(context) @ X_GO if X_WO is None else X_WO
            plant.SetFreeBodyPose(context, first_body(plant, task.object), pose)
        positions.append(plant.GetPositions(context))
    return np.array(positions)
