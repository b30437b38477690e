"""Motions of the arm: paths over s in [0, 1], and their timing.

A path is a pydrake Trajectory of the joint positions, (n, 1) rad or m. An arm plant is a finalized plant of the arm
alone, welded at its base, of joints with one degree of freedom; n is their number. Joints that do not move the tool,
such as fingers, are left alone.

Timing is minimum-jerk, not TOPPRA: the jumps in acceleration of a time-optimal profile make soft fingers sway. The
motion is still the quickest of its kind within the limits of velocity, acceleration and effort.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsStatus,
    DoDifferentialInverseKinematics,
    InverseKinematics,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, JacobianWrtVariable, Joint, MultibodyForces, RevoluteJoint
from pydrake.polynomial import Polynomial
from pydrake.solvers import SnoptSolver, SolverOptions
from pydrake.systems.controllers import InverseDynamics
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, DiscreteValues, LeafSystem
from pydrake.trajectories import PathParameterizedTrajectory, PiecewisePolynomial, PiecewisePose, Trajectory

from soft_gripper.arrays import Array
from soft_gripper.control.couplings import Couplings, couplings

POSE_TOLERANCE = 1e-6  # m and rad, tolerance of a solution
NEAR_SEED = 1.0  # rad, distance from the seed within which no other branch is searched for
NEAR_STARTS = 30  # initial postures of the solver in search of a nearer branch
MAX_STARTS = 150  # the same without a solution so far
SPACING = 0.01  # m, maximum distance of waypoints on a straight path
TURN_SPACING = 0.1  # rad, maximum rotation of the tool between waypoints
MIN_STEPS = 6  # of a straight path
MOST_STEPS = 10_000  # 100 m, farther than any arm reaches
BRANCH_JUMP = 0.2  # rad or m, of a joint between waypoints: more is another branch, or the tool could leave the line
LIMIT_GRID = np.linspace(0.0, 1.0, 301)  # parts of the duration at which the limits are checked
DURATION_MARGIN = 1.001  # safety factor on the duration, for times between the grid points
LIMIT_TOLERANCE = 1e-9  # of any unit: how far a position may exceed its limit, and an effort must stay below it
MIN_DURATION = 0.1  # s, of a motion between equal postures
_PROBE_STATES = 3
GAIN = 4.0  # 1/s, tool velocity over its distance from the desired pose
_NO_LIMIT = 1e3  # rad, m and per second, in place of an infinite limit


def tool_pose(plant: MultibodyPlant, tool: Frame, q: Array) -> RigidTransform:
    """X_WTool at joint positions q (n), rad or m."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, q)
    return tool.CalcPoseInWorld(context)


def solve_posture(
    plant: MultibodyPlant, tool: Frame, X_WTool: RigidTransform, seed: Array, coupled: Couplings | None = None
) -> Array | None:
    """Joint positions (n) that put the tool at X_WTool, within joint limits and near `seed` (n), rad or m.

    Starts from the seed. If the solution is far away or there is none, it also starts from other postures, the same in
    every call, and returns the solution nearest to the seed. Joints do not wind up: none makes a superfluous turn.
    `coupled` joints follow others; None: there are none.

    Returns:
        The positions, exact to POSE_TOLERANCE; None if none were found.
    """
    context = plant.CreateDefaultContext()
    law = coupled or no_couplings(plant)
    plant.SetPositions(context, seed)
    world = plant.world_frame()
    jacobian = plant.CalcJacobianSpatialVelocity(context, JacobianWrtVariable.kV, tool, [0, 0, 0], world, world)
    movable = (law.matrix @ (jacobian @ law.matrix).any(axis=0)).astype(bool)  # those that move the tool
    best_posture, distance = None, np.inf
    for start_index, start in enumerate(_starts(plant, seed)):
        q = _solve(plant, context, tool, X_WTool, seed, law.follow_leaders(start), law)
        q = law.follow_leaders(np.where(movable, _unwind(plant, q, seed), seed))
        plant.SetPositions(context, q)
        X_miss = tool.CalcPoseInWorld(context).InvertAndCompose(X_WTool)
        miss = max(float(np.linalg.norm(X_miss.translation())), X_miss.rotation().ToAngleAxis().angle())  # m or rad
        if np.linalg.norm(q - seed) < distance and miss <= POSE_TOLERANCE:
            best_posture, distance = q, float(np.linalg.norm(q - seed))
        if distance < NEAR_SEED or (best_posture is not None and start_index + 1 >= NEAR_STARTS):
            break
    return best_posture


def movable_joints(plant: MultibodyPlant) -> list[Joint]:
    """Lists the joints other than welds, in the order of their positions."""
    joints = [plant.get_joint(index) for index in plant.GetJointIndices()]
    return sorted((joint for joint in joints if joint.num_positions()), key=lambda joint: joint.position_start())


def no_couplings(plant: MultibodyPlant) -> Couplings:
    return couplings([joint.name() for joint in movable_joints(plant)])


def _starts(plant: MultibodyPlant, seed: Array) -> Iterator[Array]:
    """Yields the seed, then random postures around it, the first NEAR_STARTS of them ever farther away."""
    lower, upper = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
    yield np.clip(_unwind(plant, seed, seed), lower, upper)
    radius = np.pi * np.minimum(np.arange(MAX_STARTS) / NEAR_STARTS, 1.0)[:, None]
    starts = seed + radius * np.random.default_rng(0).uniform(-1.0, 1.0, (MAX_STARTS, len(seed)))
    yield from np.clip(_unwind(plant, starts, starts), lower, upper)[1:]


def _solve(
    plant: MultibodyPlant,
    context: Context,
    tool: Frame,
    X_WTool: RigidTransform,
    seed: Array,
    start: Array,
    law: Couplings,
) -> Array:
    """Result of SNOPT, whether a solution or not, (n); changes the context of the plant.

    The pose is six equations: the tool's origin, a point on its z axis and one on its x axis lie on the origin,
    on the positive z axis and in the xz half plane of the goal. They stay regular at the solution, unlike a bound
    of zero on the angle between two orientations, whose gradient vanishes there.
    """
    ik = InverseKinematics(plant, context)
    world, inf = plant.world_frame(), np.inf
    ik.AddPositionConstraint(tool, [0, 0, 0], world, X_WTool, [0, 0, 0], [0, 0, 0])
    ik.AddPositionConstraint(tool, [0, 0, 1], world, X_WTool, [0, 0, 0], [0, 0, inf])
    ik.AddPositionConstraint(tool, [1, 0, 0], world, X_WTool, [0, 0, -inf], [inf, 0, inf])
    ik.prog().AddQuadraticErrorCost(np.eye(len(seed)), seed, ik.q())
    following = np.setdiff1d(np.arange(len(seed)), law.leads)
    if len(following):
        differences = np.eye(len(seed))[following]
        differences[:, law.leads] -= law.matrix[following]
        ik.prog().AddLinearEqualityConstraint(differences, law.offset[following], ik.q())
    options = SolverOptions()
    options.SetOption(SnoptSolver.id(), "Major feasibility tolerance", 1e-9)
    options.SetOption(SnoptSolver.id(), "Major iterations limit", 100)
    q: Array = SnoptSolver().Solve(ik.prog(), start, options).GetSolution(ik.q())
    return np.clip(q, plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits())


def _unwind(plant: MultibodyPlant, q: Array, seed: Array) -> Array:
    """Turns revolute joints of q (..., n) by whole turns to within limits, and as near to the seed as these allow."""
    turn = 2 * np.pi
    min_turns = np.ceil((plant.GetPositionLowerLimits() - q) / turn)
    max_turns = np.floor((plant.GetPositionUpperLimits() - q) / turn)
    turns = np.clip(np.round((seed - q) / turn), min_turns, max_turns)
    is_revolute = [isinstance(joint, RevoluteJoint) for joint in movable_joints(plant)]
    return q + np.where(is_revolute, turns * turn, 0.0)


class UnreachableError(ValueError):
    """The arm cannot reach a pose; the message gives the position."""


class LimitError(ValueError):
    """A joint's limits rule a motion out at any speed; the message names the joint and the numbers."""


@dataclass(frozen=True)
class ArmLimits:
    """Limits of the joints, arrays (n). Positions and velocities may be unlimited."""

    lower: Array  # rad or m
    upper: Array
    velocity: Array  # rad/s or m/s, either way
    acceleration: Array  # rad/s^2 or m/s^2, either way
    effort: Array  # N m or N, either way; infinite where a joint has no actuator

    @staticmethod
    def of_plant(plant: MultibodyPlant, acceleration: float) -> "ArmLimits":
        """The limits of an arm plant; `acceleration` is for those joints that have no lower limit of it.

        Raises:
            LimitError: if a limit of velocity or effort is zero, as in files that leave them open.
        """
        effort = np.full(plant.num_velocities(), np.inf)
        for index in plant.GetJointActuatorIndices():
            actuator = plant.get_joint_actuator(index)
            effort[actuator.joint().velocity_start()] = actuator.effort_limit()
        velocity = np.minimum(-plant.GetVelocityLowerLimits(), plant.GetVelocityUpperLimits())
        for quantity, limits in (("velocity", velocity), ("effort", effort)):
            for i in np.flatnonzero(limits <= 0):
                raise LimitError(f"joint '{movable_joints(plant)[i].name()}': a limit of {quantity} of {limits[i]:g}")
        lower, upper = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
        return ArmLimits(lower, upper, velocity, np.minimum(plant.GetAccelerationUpperLimits(), acceleration), effort)


def joint_path(q0: Array, q1: Array) -> Trajectory:
    return PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.array([q0, q1]).T)


def straight_path(
    plant: MultibodyPlant, tool: Frame, q0: Array, X_WTool: RigidTransform, coupled: Couplings | None = None
) -> Trajectory:
    """The tool moves in a straight line, turning evenly, from its pose at q0 (n) to X_WTool.

    Exact at waypoints at most SPACING m apart, with a cubic spline of continuous second derivatives between them.

    Raises:
        UnreachableError: if a waypoint is out of reach or only reached by a jump to another branch, or there are more
            than MOST_STEPS of them.
    """
    X_WStart = tool_pose(plant, tool, q0)
    line = PiecewisePose.MakeLinear([0.0, 1.0], [X_WStart, X_WTool])
    X_motion = X_WStart.InvertAndCompose(X_WTool)
    distance, turn = float(np.linalg.norm(X_motion.translation())), X_motion.rotation().ToAngleAxis().angle()
    steps = max(MIN_STEPS, int(np.ceil(distance / SPACING)), int(np.ceil(turn / TURN_SPACING)))
    if steps > MOST_STEPS:
        raise UnreachableError(f"the straight path would be {steps * SPACING:.4g} m long")
    s = np.linspace(0.0, 1.0, 1 + steps)
    postures = [q0]
    for part in s[1:]:
        q = solve_posture(plant, tool, line.GetPose(part), postures[-1], coupled)
        if q is None or np.abs(q - postures[-1]).max() > BRANCH_JUMP:
            place = line.GetPose(part).translation().round(3).tolist()
            why = "is out of reach" if q is None else "takes a jump of the joints"
            raise UnreachableError(f"at {part:.0%} of a straight path, {place} m {why}")
        postures.append(q)
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(s, np.array(postures).T, False)


def timed(
    plant: MultibodyPlant, path: Trajectory, limits: ArmLimits, speed: float = 1.0, coupled: Couplings | None = None
) -> PathParameterizedTrajectory:
    """The motion along a path from rest to rest, as quickly as the limits allow if `speed` is 1.

    The part s(t) of the path is the minimum-jerk polynomial. A time-optimal profile would be quicker, but its jumps
    of the acceleration make a soft gripper sway. Velocity, acceleration and the effort of inverse dynamics stay
    within the limits at every instant. A `speed` in (0, 1] takes 1 / speed times the shortest duration.

    Raises:
        LimitError: if the path leaves the position limits, or a joint cannot hold the arm at rest somewhere on it.
    """
    unit = PathParameterizedTrajectory(path, _minimum_jerk(1.0))
    q, v, vdot = (unit.MakeDerivative(order).vector_values(LIMIT_GRID).T for order in range(3))
    law = coupled or no_couplings(plant)
    _check_inside(plant, law, "position", q, limits.lower - LIMIT_TOLERANCE, limits.upper + LIMIT_TOLERANCE)
    q, v, vdot = np.split(np.unique(np.hstack([q, v, vdot]), axis=0), 3, axis=1)  # one state if the arm stays
    rest, linear, quadratic = map(law.leader_efforts, _efforts(plant, q, v, vdot))
    _check_inside(plant, law, "effort at rest", rest, LIMIT_TOLERANCE - limits.effort, limits.effort - LIMIT_TOLERANCE)
    zeros = np.zeros_like(v)
    rate = min(
        _highest_rate(np.array([v, -v]), zeros, limits.velocity),
        _highest_rate(zeros, np.array([vdot, -vdot]), limits.acceleration),
        _highest_rate(linear, quadratic, limits.effort - rest),
        _highest_rate(-linear, -quadratic, limits.effort + rest),
    )
    duration = max(DURATION_MARGIN / rate, MIN_DURATION) / speed
    return PathParameterizedTrajectory(path, _minimum_jerk(duration))


def _minimum_jerk(duration: float) -> PiecewisePolynomial:
    """Polynomial from 0 to 1 in the duration T, at rest and without acceleration at both ends.

    s(t) = 10 (t/T)^3 - 15 (t/T)^4 + 6 (t/T)^5 minimises the integral of the squared jerk (Flash & Hogan, 1985).
    """
    coefficients = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0]) / duration ** np.arange(6)
    return PiecewisePolynomial([Polynomial(coefficients)], [0.0, duration])


def _efforts(plant: MultibodyPlant, q: Array, v: Array, vdot: Array) -> tuple[Array, Array, Array]:
    """Static effort, and coefficients of the rate (damping) and of its square (inertia), N m or N, all (K, n).

    q, v and vdot belong to a motion of 1 s. One that is r times as fast takes rest + linear r + quadratic r^2.
    """
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
    efforts = np.empty((3, *v.shape))
    for k in range(len(q)):
        plant.SetPositions(context, q[k])  # whose kinematics serve all three velocities
        for i, rate in enumerate((0.0, 1.0, -1.0)):
            plant.SetVelocities(context, rate * v[k])
            plant.CalcForceElementsContribution(context, forces)
            efforts[i, k] = plant.CalcInverseDynamics(context, rate**2 * vdot[k], forces)
    static_effort, forward_effort, backward_effort = efforts
    return static_effort, (forward_effort - backward_effort) / 2, (forward_effort + backward_effort) / 2 - static_effort


def _highest_rate(linear: Array, quadratic: Array, margin: Array) -> float:
    """The largest r up to which linear r + quadratic r^2 <= margin everywhere; infinite if nothing bounds it."""
    linear, quadratic, margin = np.broadcast_arrays(linear, quadratic, margin)
    bounds = np.isfinite(margin) & ((linear != 0) | (quadratic != 0))
    linear, quadratic, margin = linear[bounds], quadratic[bounds], margin[bounds]
    with np.errstate(invalid="ignore", divide="ignore"):
        denominator = linear + np.sqrt(linear**2 + 4 * quadratic * margin)
        rates = 2 * margin / denominator
    return float(rates.min(initial=np.inf, where=denominator > 0))


def _check_inside(plant: MultibodyPlant, law: Couplings, name: str, values: Array, lower: Array, upper: Array) -> None:
    """Raises LimitError for the value, of (K, n), that lies furthest outside."""
    excess = np.maximum(lower - values, values - upper)
    k, i = np.unravel_index(excess.argmax(), excess.shape)
    if excess[k, i] > 0:
        names = [joint.name() for joint in movable_joints(plant)]
        leader = law.leads[abs(law.matrix[i]).argmax()]
        limits = f"{lower[i]:.4g} to {upper[i]:.4g}" + (f"; it follows '{names[leader]}'" if i != leader else "")
        raise LimitError(f"joint '{names[i]}': {name} {values[k, i]:.4g} is outside of its limits, {limits}")


def arm_fingerprint(plant: MultibodyPlant, tool: Frame) -> bytes:
    """Key of an arm plant: equal for equal limits, efforts and tool poses, whatever files they were read from.

    Efforts and poses are compared at a few states drawn at random, always the same: two arms that differ in a length,
    a mass, a damping or in gravity are alike there with probability zero.
    """
    n, limits = plant.num_velocities(), ArmLimits.of_plant(plant, np.inf)
    q, v, vdot = np.random.default_rng(0).uniform(-1.0, 1.0, (3, _PROBE_STATES, n))
    poses = [tool_pose(plant, tool, posture).GetAsMatrix34() for posture in q]
    is_revolute = [isinstance(joint, RevoluteJoint) for joint in movable_joints(plant)]
    numbers = (*vars(limits).values(), *_efforts(plant, q, v, vdot), *poses, np.array(is_revolute))
    return b"".join(np.ascontiguousarray(array).tobytes() for array in numbers)


class ToolFollower(LeafSystem):
    """Moves the tool of an arm to a pose, within their limits of position, velocity and acceleration.

    ::

        X_WTool ------------> +--------------+
                              | ToolFollower | ---> desired_state  (2 n) positions, then velocities, of the joints
        robot_state (2 n) --> +--------------+

    At every sample the desired tool velocity is GAIN times its error, turning and shifting evenly; Drake's
    DoDifferentialInverseKinematics finds the joint velocities that come nearest to that in the same direction. Where
    there are none, as when the target jumps aside in full motion, or is not finite, the joints brake. `robot_state` is
    read once, as the simulation begins.
    """

    def __init__(
        self, arm: MultibodyPlant, tool: Frame, limits: ArmLimits, period: float, coupled: Couplings | None = None
    ):
        """`arm` is a finalized plant of the arm alone, with `tool` in it; samples every `period` s."""
        super().__init__()
        n = arm.num_positions()
        self._arm, self._tool, self._period, self._law = arm, tool, period, coupled or no_couplings(arm)
        self._scratch, self._brake = arm.CreateDefaultContext(), limits.acceleration * period
        self._parameters = _parameters(limits, self._law, period)
        self._target = self.DeclareAbstractInputPort("X_WTool", AbstractValue.Make(RigidTransform()))
        self._robot_state = self.DeclareVectorInputPort("robot_state", 2 * n)
        self.DeclareStateOutputPort("desired_state", self.DeclareDiscreteState(2 * n))
        self.DeclareInitializationDiscreteUpdateEvent(self._begin)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        positions, velocities = np.split(self._robot_state.Eval(context), 2)
        values.set_value(np.concatenate([positions, np.zeros_like(velocities)]))

    def _update(self, context: Context, values: DiscreteValues) -> None:
        state = context.get_discrete_state_vector().value()
        self._arm.SetPositionsAndVelocities(self._scratch, state)
        positions, velocities = np.split(state, 2)
        X_WTool, X_WGoal = self._tool.CalcPoseInWorld(self._scratch), self._target.Eval(context)
        turn = (X_WGoal.rotation() @ X_WTool.rotation().inverse()).ToAngleAxis()
        shift = X_WGoal.translation() - X_WTool.translation()
        missing = GAIN * np.concatenate([turn.angle() * turn.axis(), shift])
        velocity = velocities - np.clip(velocities, -self._brake, self._brake)
        if np.isfinite(missing @ missing):
            velocity = self._joint_velocities(missing, positions, velocities, velocity)
        values.set_value(np.concatenate([positions + self._period * velocity, velocity]))

    def _joint_velocities(self, missing: Array, positions: Array, velocities: Array, fallback: Array) -> Array:
        """Joint velocities that move the tool by a desired velocity; `fallback` where there are none."""
        world, leads, by_v = self._arm.world_frame(), self._law.leads, JacobianWrtVariable.kV
        jacobian = self._arm.CalcJacobianSpatialVelocity(self._scratch, by_v, self._tool, [0, 0, 0], world, world)
        leader_jacobian, state = jacobian @ self._law.matrix, (positions[leads], velocities[leads])
        result = DoDifferentialInverseKinematics(*state, missing, leader_jacobian, self._parameters)
        if result.status == DifferentialInverseKinematicsStatus.kNoSolutionFound:
            return fallback
        return np.asarray(self._law.matrix @ result.joint_velocities)


def _parameters(limits: ArmLimits, law: Couplings, period: float) -> DifferentialInverseKinematicsParameters:
    parameters = DifferentialInverseKinematicsParameters(len(law.leads), len(law.leads))
    bounds = np.clip([limits.lower, limits.upper, limits.velocity], -_NO_LIMIT, _NO_LIMIT)
    lower, upper, velocity = bounds[:, law.leads]
    parameters.set_time_step(period)
    parameters.set_joint_position_limits((lower, upper))
    parameters.set_joint_velocity_limits((-velocity, velocity))
    acceleration = limits.acceleration[law.leads]
    parameters.set_joint_acceleration_limits((-acceleration, acceleration))
    return parameters


class GravityCompensation(Diagram):
    """Drake's InverseDynamics for gravity alone, together with the plant that it needs.

    ::

        state (2 n) ---> GravityCompensation ---> torque (n) N m or N, of the joints in the order of their velocities
    """

    def __init__(self, arm: MultibodyPlant):
        """`arm` is a finalized plant of the arm alone, with its load."""
        super().__init__()
        self._arm = arm  # InverseDynamics does not keep it alive
        builder = DiagramBuilder()
        mode = InverseDynamics.InverseDynamicsMode.kGravityCompensation
        dynamics = builder.AddNamedSystem("inverse_dynamics", InverseDynamics(arm, mode))
        builder.ExportInput(dynamics.get_input_port_estimated_state(), "state")
        builder.ExportOutput(dynamics.get_output_port(), "torque")
        builder.BuildInto(self)
