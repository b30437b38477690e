"""No motion of a task leads through anything: all are looked at before anything moves."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame
from pydrake.systems.framework import Diagram

from soft_gripper.arrays import Array
from soft_gripper.diagrams.manipulation.arm import carried_models, gripper_model
from soft_gripper.diagrams.manipulation.collision_check import first_collision
from soft_gripper.diagrams.placing import first_body, own_frame
from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.errors import InputError
from soft_gripper.task_phases import Phase

STEP = 0.02  # rad or m, that a joint moves at most between two postures that are looked at
NOWHERE = RigidTransform([0.0, 0.0, 1e3])


def check_ways(
    diagram: Diagram,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    scenario: Scenario,
    fingers: Sequence[PlantFinger],
    phases: Sequence[Phase],
) -> None:
    """Looks at arm, gripper and, while it is held, the object, all along the motions of a task.

    The fingers are straight and the object lies in them as it was grasped; in a rescue nobody knows where it is.

    Raises:
        InputError: naming the phase, what meets what, and where.
    """
    models = [scenario.arm.model, *(model.name for model in carried_models(scenario))]
    robot = {body for name in models for body in plant.GetBodyIndices(plant.GetModelInstanceByName(name))}
    tool = own_frame(plant, gripper_model(scenario, fingers), "models")
    for i, phase in enumerate(phases):
        postures = _postures(phase)
        positions = _positions(plant, scenario, tool, postures, _place(scenario, i))
        held = {first_body(plant, scenario.task.object).index()} if phase.holds else set()
        collision = first_collision(diagram, plant, scene_graph, robot | held, positions)
        if collision is not None:
            failed = next((k for k, other in enumerate(phases) if other.rescue in range(i - 2, i + 1)), i)
            where = f"task.phases[{failed if i >= len(scenario.task.phases) else i}]"
            part = collision.index / (len(postures) - 1)
            raise InputError(where, "name", phase.name, f"leads through something: {part:.0%} on its way {collision}")


def _postures(phase: Phase) -> Array:
    """Postures along the motion of a phase, about evenly spaced, (K, n)."""
    fine = phase.motion.vector_values(np.linspace(0.0, phase.duration, 500)).T
    travel = np.concatenate([[0.0], np.abs(np.diff(fine, axis=0)).max(axis=1).cumsum()])
    count = 2 + int(travel[-1] / STEP)
    evenly = np.linspace(0.0, travel[-1], count)
    return np.array([np.interp(evenly, travel, joint) for joint in fine.T]).T


def _place(scenario: Scenario, number: int) -> RigidTransform | None:
    """Where the object lies in a phase; None: in the fingers."""
    configs, task = scenario.task.phases, scenario.task
    if number >= len(configs) or not task.object:
        return NOWHERE
    if configs[number].holds:
        return None
    if any(config.holds for config in configs[:number]):
        return task.X_WGoal.GetDeterministicValue()
    (begin,) = (model.X_PC for model in scenario.models if model.name == task.object)
    return begin.GetDeterministicValue()


def _positions(
    plant: MultibodyPlant, scenario: Scenario, tool: Frame, postures: Array, X_WO: RigidTransform | None
) -> Array:
    """Positions of the whole plant at postures (K, n) of the arm, (K, nq)."""
    context = plant.CreateDefaultContext()
    arm, X_GO = plant.GetModelInstanceByName(scenario.arm.model), scenario.task.X_OG.GetDeterministicValue().inverse()
    positions = []
    for posture in postures:
        plant.SetPositions(context, arm, posture)
        if scenario.task.object:
            pose = tool.CalcPoseInWorld(context) @ X_GO if X_WO is None else X_WO
            plant.SetFreeBodyPose(context, first_body(plant, scenario.task.object), pose)
        positions.append(plant.GetPositions(context))
    return np.array(positions)
