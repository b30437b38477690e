"""Motions of the arm: paths over s in [0, 1], and their timing.

A path is a pydrake Trajectory of the joint positions, (n, 1) rad or m; an arm plant and its joints are those of
`arm_kinematics`.

Timing is minimum-jerk, not TOPPRA: the jumps in acceleration of a time-optimal profile make soft fingers sway. The
motion is still the quickest of its kind within the limits of velocity, acceleration and effort.
"""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, MultibodyForces
from pydrake.polynomial import Polynomial
from pydrake.trajectories import PathParameterizedTrajectory, PiecewisePolynomial, PiecewisePose, Trajectory

from soft_gripper.arrays import Array
from soft_gripper.control.arm_kinematics import movable_joints, solve_posture, tool_pose

TURN_SPACING = 0.1  # rad, that the tool turns at most between waypoints
MIN_STEPS = 6  # of a straight path
BRANCH_JUMP = 0.2  # rad or m, of a joint between waypoints: more is another branch, or the tool could leave the line
LIMIT_GRID = np.linspace(0.0, 1.0, 301)  # parts of the duration at which the limits are checked
DURATION_MARGIN = 1.001  # of the duration, for what lies between the points of the grid
LIMIT_TOLERANCE = 1e-9  # of any unit: how far a position may exceed its limit, and an effort must stay below it
MIN_DURATION = 0.1  # s, of a motion between equal postures


class UnreachableError(ValueError):
    """The arm cannot take the tool there; the message gives the place."""


class LimitError(ValueError):
    """A joint's limits rule a motion out at any speed; the message names the joint and the numbers."""


@dataclass(frozen=True)
class ArmLimits:
    """What the joints may do, arrays (n). Positions and velocities may be unlimited."""

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
        for what, limits in (("velocity", velocity), ("effort", effort)):
            for i in np.flatnonzero(limits <= 0):
                raise LimitError(f"joint '{movable_joints(plant)[i].name()}': a limit of {what} of {limits[i]:g}")
        lower, upper = plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits()
        return ArmLimits(lower, upper, velocity, np.minimum(plant.GetAccelerationUpperLimits(), acceleration), effort)


def joint_path(q0: Array, q1: Array) -> Trajectory:
    """Straight in joint space."""
    return PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.array([q0, q1]).T)


def straight_path(
    plant: MultibodyPlant, tool: Frame, q0: Array, X_WTool: RigidTransform, spacing: float = 0.01
) -> Trajectory:
    """The tool moves in a straight line, turning evenly, from its pose at q0 (n) to X_WTool.

    Exact at waypoints at most `spacing` m apart, with a cubic spline of continuous second derivatives between them.

    Raises:
        UnreachableError: if a waypoint is out of reach, or only reached by a jump to another branch.
    """
    X_WStart = tool_pose(plant, tool, q0)
    line = PiecewisePose.MakeLinear([0.0, 1.0], [X_WStart, X_WTool])
    s = np.linspace(0.0, 1.0, 1 + _steps(X_WStart.InvertAndCompose(X_WTool), spacing))
    postures = [q0]
    for part in s[1:]:
        q = solve_posture(plant, tool, line.GetPose(part), postures[-1])
        if q is None or np.abs(q - postures[-1]).max() > BRANCH_JUMP:
            place = line.GetPose(part).translation().round(3).tolist()
            why = "is out of reach" if q is None else "takes a jump of the joints"
            raise UnreachableError(f"at {part:.0%} of a straight path, {place} m {why}")
        postures.append(q)
    return PiecewisePolynomial.CubicWithContinuousSecondDerivatives(s, np.array(postures).T, False)


def _steps(X_AB: RigidTransform, spacing: float) -> int:
    """The number of steps of a motion of the tool from A to B."""
    distance, turn = float(np.linalg.norm(X_AB.translation())), X_AB.rotation().ToAngleAxis().angle()
    return max(MIN_STEPS, int(np.ceil(distance / spacing)), int(np.ceil(turn / TURN_SPACING)))


def timed(
    plant: MultibodyPlant, path: Trajectory, limits: ArmLimits, speed: float = 1.0
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
    _check_inside(plant, "position", q, limits.lower - LIMIT_TOLERANCE, limits.upper + LIMIT_TOLERANCE)
    rest, linear, quadratic = _efforts(plant, q, v, vdot)
    _check_inside(plant, "effort at rest", rest, LIMIT_TOLERANCE - limits.effort, limits.effort - LIMIT_TOLERANCE)
    none = np.zeros_like(v)
    rate = min(
        _highest_rate(np.array([v, -v]), none, limits.velocity),
        _highest_rate(none, np.array([vdot, -vdot]), limits.acceleration),
        _highest_rate(linear, quadratic, limits.effort - rest),
        _highest_rate(-linear, -quadratic, limits.effort + rest),
    )
    duration = max(DURATION_MARGIN / rate, MIN_DURATION) / speed
    return PathParameterizedTrajectory(path, _minimum_jerk(duration))


def _minimum_jerk(duration: float) -> PiecewisePolynomial:
    """From 0 to 1 in the duration T, at rest and without acceleration at both ends.

    s(t) = 10 (t/T)^3 - 15 (t/T)^4 + 6 (t/T)^5 minimises the integral of the squared jerk (Flash & Hogan, 1985).
    """
    coefficients = np.array([0.0, 0.0, 0.0, 10.0, -15.0, 6.0]) / duration ** np.arange(6)
    return PiecewisePolynomial([Polynomial(coefficients)], [0.0, duration])


def _efforts(plant: MultibodyPlant, q: Array, v: Array, vdot: Array) -> tuple[Array, Array, Array]:
    """What the joints take at rest, and what grows with the rate (damping) and its square (inertia), all (K, n).

    q, v and vdot belong to a motion of 1 s. One that is r times as fast takes rest + linear r + quadratic r^2.
    """
    rest = _inverse_dynamics(plant, q, 0.0 * v, 0.0 * vdot)
    forth = _inverse_dynamics(plant, q, v, vdot)
    back = _inverse_dynamics(plant, q, -v, vdot)
    return rest, (forth - back) / 2, (forth + back) / 2 - rest


def _inverse_dynamics(plant: MultibodyPlant, q: Array, v: Array, vdot: Array) -> Array:
    """Effort of the joints against inertia, weight and damping, N m or N, (K, n)."""
    context, forces = plant.CreateDefaultContext(), MultibodyForces(plant)
    efforts = np.empty_like(v)
    for k in range(len(q)):
        plant.SetPositionsAndVelocities(context, np.concatenate([q[k], v[k]]))
        plant.CalcForceElementsContribution(context, forces)
        efforts[k] = plant.CalcInverseDynamics(context, vdot[k], forces)
    return efforts


def _highest_rate(linear: Array, quadratic: Array, margin: Array) -> float:
    """The largest r up to which linear r + quadratic r^2 <= margin everywhere; infinite if nothing bounds it."""
    linear, quadratic, margin = np.broadcast_arrays(linear, quadratic, margin)
    bounds = np.isfinite(margin) & ((linear != 0) | (quadratic != 0))
    linear, quadratic, margin = linear[bounds], quadratic[bounds], margin[bounds]
    with np.errstate(invalid="ignore", divide="ignore"):
        denominator = linear + np.sqrt(linear**2 + 4 * quadratic * margin)
        rates = 2 * margin / denominator
    return float(rates.min(initial=np.inf, where=denominator > 0))


def _check_inside(plant: MultibodyPlant, what: str, values: Array, lower: Array, upper: Array) -> None:
    """Raises LimitError for the value, of (K, n), that lies furthest outside."""
    excess = np.maximum(lower - values, values - upper)
    k, i = np.unravel_index(excess.argmax(), excess.shape)
    if excess[k, i] > 0:
        name = movable_joints(plant)[i].name()
        limits = f"{lower[i]:.4g} to {upper[i]:.4g}"
        raise LimitError(f"joint '{name}': {what} {values[k, i]:.4g} is outside of its limits, {limits}")
