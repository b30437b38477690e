"""The arm's kinematics: the pose of its tool, and joint positions for a pose of the tool.

An arm plant is a finalized plant of the arm alone, welded at its base, of joints with one degree of freedom;
n is their number. Joints that do not move the tool, such as fingers, are left alone.
"""

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import InverseKinematics
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable, Joint, RevoluteJoint
from pydrake.solvers import SnoptSolver, SolverOptions

from soft_gripper.arrays import Array

POSE_TOLERANCE = 1e-6  # m and rad, by which a solution may miss
NEAR_SEED = 1.0  # rad, distance from the seed within which no other branch is searched for
NEAR_STARTS = 30  # initial postures of the solver in search of a nearer branch
MAX_STARTS = 150  # the same while it has no solution


def tool_pose(plant: MultibodyPlant, tool: Frame, q: Array) -> RigidTransform:
    """X_WTool at joint positions q (n), rad or m."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    return tool.CalcPoseInWorld(context)


def solve_posture(plant: MultibodyPlant, tool: Frame, X_WTool: RigidTransform, seed: Array) -> Array | None:
    """Joint positions (n) that put the tool at X_WTool, within joint limits and near `seed` (n), rad or m.

    Starts from the seed. If the solution is far away or there is none, it also starts from other postures, the same in
    every call, and returns the solution nearest to the seed. Joints do not wind up: none makes a superfluous turn.

    Returns:
        The positions, exact to POSE_TOLERANCE; None if none were found.
    """
    moving = _moves_tool(plant, tool, seed)
    nearest, distance = None, np.inf
    for number, start in enumerate(_starts(plant, seed)):
        if distance < NEAR_SEED or (nearest is not None and number >= NEAR_STARTS):
            break
        q = _solve(plant, tool, X_WTool, seed, start)
        q = np.where(moving, _unwound(plant, q, seed), seed)
        if np.linalg.norm(q - seed) < distance and _miss(tool_pose(plant, tool, q), X_WTool) <= POSE_TOLERANCE:
            nearest, distance = q, float(np.linalg.norm(q - seed))
    return nearest


def movable_joints(plant: MultibodyPlant) -> list[Joint]:
    """The joints that are not welds, in the order of their positions."""
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    return sorted((joint for joint in joints if joint.num_positions()), key=lambda joint: joint.position_start())


def _starts(plant: MultibodyPlant, seed: Array) -> Array:
    """The seed and random postures around it, NEAR_STARTS of them spread ever wider; (MAX_STARTS, n)."""
    spread = np.pi * np.minimum(np.arange(MAX_STARTS) / NEAR_STARTS, 1.0)[:, None]
    starts = seed + spread * np.random.default_rng(0).uniform(-1.0, 1.0, (MAX_STARTS, len(seed)))
    inside = _unwound(plant, starts, starts)
    return np.clip(inside, plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits())


def _solve(plant: MultibodyPlant, tool: Frame, X_WTool: RigidTransform, seed: Array, start: Array) -> Array:
    """What SNOPT ends at, a solution or not, (n).

    The pose is six equations: the tool's origin, a point on its z axis and one on its x axis lie on the origin,
    on the positive z axis and in the xz half plane of the goal. They stay regular at the solution, unlike a bound
    of zero on the angle between two orientations, whose gradient vanishes there.
    """
    ik = InverseKinematics(plant)
    world, inf = plant.world_frame(), np.inf
    ik.AddPositionConstraint(tool, [0, 0, 0], world, X_WTool, [0, 0, 0], [0, 0, 0])
    ik.AddPositionConstraint(tool, [0, 0, 1], world, X_WTool, [0, 0, 0], [0, 0, inf])
    ik.AddPositionConstraint(tool, [1, 0, 0], world, X_WTool, [0, 0, -inf], [inf, 0, inf])
    ik.prog().AddQuadraticErrorCost(np.eye(len(seed)), seed, ik.q())
    options = SolverOptions()
    options.SetOption(SnoptSolver.id(), "Major feasibility tolerance", 1e-9)
    options.SetOption(SnoptSolver.id(), "Major iterations limit", 100)
    q: Array = SnoptSolver().Solve(ik.prog(), start, options).GetSolution(ik.q())
    return np.clip(q, plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits())


def _unwound(plant: MultibodyPlant, q: Array, seed: Array) -> Array:
    """q (..., n), the revolute joints by whole turns within limits and then as near to the seed as these allow."""
    turn = 2 * np.pi
    fewest = np.ceil((plant.GetPositionLowerLimits() - q) / turn)
    most = np.floor((plant.GetPositionUpperLimits() - q) / turn)
    turns = np.clip(np.round((seed - q) / turn), fewest, most)
    is_revolute = [isinstance(joint, RevoluteJoint) for joint in movable_joints(plant)]
    return q + np.where(is_revolute, turns * turn, 0.0)


def _moves_tool(plant: MultibodyPlant, tool: Frame, q: Array) -> Array:
    """Which joints move the tool, (n) bool."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    world, by_v = plant.world_frame(), JacobianWrtVariable.kV
    jacobian = plant.CalcJacobianSpatialVelocity(context, by_v, tool, [0, 0, 0], world, world)
    return jacobian.any(axis=0)


def _miss(X_WA: RigidTransform, X_WB: RigidTransform) -> float:
    """Distance, m, or angle, rad, between two poses, whichever is larger."""
    X_AB = X_WA.InvertAndCompose(X_WB)
    return max(float(np.linalg.norm(X_AB.translation())), X_AB.rotation().ToAngleAxis().angle())
