"""The task of a scenario, applied: planned before anything moves, then controlled by a TaskMachine.

The pose of an object is reported with an error (`task.pose_error`), so that a moved object is reported at its new
place. The path check uses the reported pose too, because the true one is not known before the fingers arrive. Pick and
place uses steps of 5 ms and a stiction tolerance of 0.1 mm/s: at 10 ms and 1 mm/s a heavy or slippery object creeps
and turns in the fingers.
"""

import math
from collections import OrderedDict
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import PenetrationAsPointPair, SceneGraph, SceneGraphInspector
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Frame, RigidBody
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, InputPort, OutputPort
from pydrake.trajectories import Trajectory

from soft_gripper.arrays import Array
from soft_gripper.cached import get_or_make
from soft_gripper.control.arm_motion import (
    ArmLimits,
    LimitError,
    ToolFollower,
    UnreachableError,
    arm_fingerprint,
    joint_path,
    solve_posture,
    straight_path,
    timed,
    tool_pose,
)
from soft_gripper.control.task import Phase, Rules, TaskMachine
from soft_gripper.diagrams.arm import Arm, carried_models
from soft_gripper.diagrams.scene import first_body, own_frame
from soft_gripper.diagrams.wiring.drive import External
from soft_gripper.errors import InputError
from soft_gripper.scenario.schema import ModelConfig, PhaseConfig, TaskConfig

TOUCH_DEPTH = 1e-3  # m, penetration that counts as a touch


@dataclass(frozen=True)
class Collision:
    """A body of the robot that penetrates a body that is not part of the robot."""

    index: int  # of the colliding positions
    body: str  # of the robot; names are model::body
    obstacle: str
    depth: float  # m

    def __str__(self) -> str:
        return f"'{self.body}' is {self.depth * 1e3:.1f} mm inside '{self.obstacle}'"


def first_collision(
    root: Context,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    robot: Collection[BodyIndex],
    positions: Array,
) -> Collision | None:
    """Steps through positions of the whole plant, (K, nq), until the robot collides.

    Meshes count as their convex hulls. Bodies welded to the same body, and pairs filtered by a model, never collide.

    Returns the deepest collision at the first positions with one, None if there is none; nothing in between is checked.
    The bodies of the robot, and its payload, may touch each other. Positions in `root` change.
    """
    context = plant.GetMyMutableContextFromRoot(root)
    scene_context = scene_graph.GetMyContextFromRoot(root)
    robot_bodies = frozenset(robot)
    for index, q in enumerate(positions):
        plant.SetPositions(context, q)
        query = scene_graph.get_query_output_port().Eval(scene_context)
        for pair in sorted(query.ComputePointPairPenetration(), key=lambda pair: -pair.depth):
            bodies = _bodies(plant, query.inspector(), pair)
            if pair.depth > TOUCH_DEPTH and len(bodies & robot_bodies) == 1:
                (body,), (obstacle,) = bodies & robot_bodies, bodies - robot_bodies
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
    """Reported pose of the first link of the task's object in the world: the true pose plus `pose_error`."""
    (X_WO,) = (model.X_PC.GetDeterministicValue() for model in models if model.name == task.object)
    error = task.pose_error
    shift = np.array([error.x, error.y, 0.0])
    orientation = RotationMatrix.MakeZRotation(error.yaw) @ X_WO.rotation()
    return RigidTransform(orientation, X_WO.translation() + shift)


POSTURE_SPACING = 0.02  # rad or m, maximum motion of a joint between two checked postures
OUT_OF_THE_WAY = RigidTransform([0.0, 0.0, 1e3])


def check_paths(
    diagram: Diagram,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    models: Sequence[ModelConfig],
    arm: Arm,
    task: TaskConfig,
    phases: Sequence[Phase],
    begin: Array | None = None,
) -> None:
    """Checks the arm, the gripper and, while it is held, the object for collisions along all motions of a task.

    The fingers are straight. The object is at its reported pose until it is grasped, then at its planned pose in the
    fingers; during a rescue its pose is unknown. A soft object, which gives way, is not checked. Others stay where they
    are in the positions `begin`, (nq,); None: in those of the plant.

    Raises:
        InputError: naming the phase, the colliding bodies, and the place.
    """
    names = [arm.name, *(model.name for model in carried_models(models, arm.name))]
    robot = {body for name in names for body in plant.GetBodyIndices(plant.GetModelInstanceByName(name))}
    tool = own_frame(plant, arm.tool_model, "models")
    root = diagram.CreateDefaultContext()
    for i, phase in enumerate(phases):
        postures = _postures(phase)
        positions = _positions(plant, arm, task, tool, postures, _place(models, task, i), begin)
        held_bodies = {body.index() for body in _object_bodies(plant, task)} if phase.holds else set()
        collision = first_collision(root, plant, scene_graph, robot | held_bodies, positions)
        if collision is not None:
            failed = next((k for k, other in enumerate(phases) if other.rescue in range(i - 2, i + 1)), i)
            where = f"task.phases[{failed if i >= len(task.phases) else i}]"
            fraction = collision.index / (len(postures) - 1)
            raise InputError(where, "name", phase.name, f"collides: {fraction:.0%} along its path, {collision}")


def _object_bodies(plant: MultibodyPlant, task: TaskConfig) -> list[RigidBody]:
    """The first link of the object; none if there is no object, or one without links."""
    if task.object is None or not plant.GetBodyIndices(plant.GetModelInstanceByName(task.object)):
        return []
    return [first_body(plant, task.object)]


def _postures(phase: Phase) -> Array:
    """Postures along the motion of a phase, about evenly spaced, (K, n)."""
    dense_postures = phase.motion.vector_values(np.linspace(0.0, phase.duration, 500)).T
    travel = np.concatenate([[0.0], np.abs(np.diff(dense_postures, axis=0)).max(axis=1).cumsum()])
    count = 2 + int(travel[-1] / POSTURE_SPACING)
    even_travel = np.linspace(0.0, travel[-1], count)
    return np.array([np.interp(even_travel, travel, joint) for joint in dense_postures.T]).T


def _place(models: Sequence[ModelConfig], task: TaskConfig, phase_index: int) -> RigidTransform | None:
    """The assumed pose of the object in a phase; None: in the fingers."""
    configs = task.phases
    if phase_index >= len(configs) or task.object is None:
        return OUT_OF_THE_WAY
    if configs[phase_index].holds:
        return None
    if any(config.holds for config in configs[:phase_index]):
        return task.X_WGoal.GetDeterministicValue()
    return reported_pose(task, models)


def _positions(
    plant: MultibodyPlant,
    arm: Arm,
    task: TaskConfig,
    tool: Frame,
    postures: Array,
    X_WO: RigidTransform | None,
    begin: Array | None,
) -> Array:
    """Positions of the whole plant at postures (K, n) of the arm, (K, nq)."""
    context = plant.CreateDefaultContext()
    if begin is not None:
        plant.SetPositions(context, begin)
    X_GO = task.X_OG.GetDeterministicValue().inverse()
    positions = []
    for posture in postures:
        plant.SetPositions(context, arm.model, posture)
        for body in _object_bodies(plant, task):
            plant.SetFreeBodyPose(context, body, tool.CalcPoseInWorld(context) @ X_GO if X_WO is None else X_WO)
        positions.append(plant.GetPositions(context))
    return np.array(positions)


RESCUE = ("rescue: open", "rescue: rise", "rescue: home")


_MAX_PLANS = 16  # of about 30 motions each, 0.2 MB
_plans: OrderedDict[tuple[bytes | str, ...], tuple[Phase, ...]] = OrderedDict()


def plan_phases(task: TaskConfig, models: Sequence[ModelConfig], arm: Arm) -> tuple[Phase, ...]:
    """The phases of the task, followed by a rescue for each that can fail: fingers open, straight up, home.

    Planning takes longer than building all the rest of a station, so that the same plan is made once.

    Raises:
        InputError: naming the phase whose goal the arm cannot reach, or cannot reach by the requested motion.
    """
    planner = MotionPlanner(task, models, arm)
    poses = [pose.GetDeterministicValue() for pose in (task.X_OG, task.X_WGoal)]
    if task.object is not None:
        poses.append(reported_pose(task, models))
    law = arm.couplings
    numbers = (arm.home, arm.config.acceleration, law.matrix, law.offset, [pose.GetAsMatrix34() for pose in poses])
    arrays = (np.array(values).tobytes() for values in numbers)
    key: tuple[bytes | str, ...] = (arm_fingerprint(arm.plant, arm.tool), repr(task.phases), *arrays)
    return get_or_make(_plans, key, lambda: _plan_motions(planner, task.phases, arm.home), _MAX_PLANS)


def _plan_motions(planner: "MotionPlanner", configs: Sequence[PhaseConfig], home: Array) -> tuple[Phase, ...]:
    watched_indices = [i for i, config in enumerate(configs) if config.holds or config.until]
    end = len(configs) + len(RESCUE) * len(watched_indices)
    phases: list[Phase] = []
    posture = home
    opening = math.nan
    for i, config in enumerate(configs):
        motion = planner.motion(f"task.phases[{i}] '{config.name}'", config, posture)
        posture = end_of(motion)
        opening = opening if config.opening is None else config.opening
        follower = i + 1 if i + 1 < len(configs) else end
        rescue = len(configs) + len(RESCUE) * watched_indices.index(i) if i in watched_indices else None
        phases.append(Phase(config.name, motion, opening, follower, config.until, config.rest, config.holds, rescue))
    for i in watched_indices:
        motions = planner.rescue(f"task.phases[{i}] '{configs[i].name}', its rescue", end_of(phases[i].motion))
        for name, motion in zip(RESCUE, motions, strict=True):
            follower = end if name == RESCUE[-1] else len(phases) + 1
            until = "released" if name == RESCUE[0] else None
            phases.append(Phase(name, motion, phases[0].opening, follower, until))
    return tuple(phases)


def end_of(motion: Trajectory) -> Array:
    """The final posture of a motion, (n) rad or m."""
    return motion.value(motion.end_time())[:, 0]


class MotionPlanner:
    """Plans single motions of the arm of a task."""

    def __init__(self, task: TaskConfig, models: Sequence[ModelConfig], arm: Arm):
        self._arm, self._task, self._models = arm, task, models
        try:
            self._limits = ArmLimits.of_plant(arm.plant, arm.config.acceleration)
        except LimitError as error:
            raise InputError("arm", "model", arm.name, str(error)) from None

    def motion(self, where: str, config: PhaseConfig, start: Array) -> Trajectory:
        """The motion of the arm in a phase that starts from the posture `start`.

        Raises:
            InputError: if the arm cannot do it.
        """
        if config.posture is not None:
            count = len(self._arm.couplings.leads)
            if len(config.posture) != count:
                expected = f"give {count} numbers, one per joint" + (
                    " that follows no other" if count < len(start) else ""
                )
                raise InputError(where, "posture", config.posture, expected)
            posture = self._arm.couplings.full(np.array(config.posture))
            return self._timed(where, joint_path(start, posture), config.speed)
        if config.to == "home":
            return self._timed(where, joint_path(start, self._arm.home), config.speed)
        if config.to is not None:
            return self._to_pose(where, config, self._goal(config), start)
        return self._timed(where, joint_path(start, start), config.speed)

    def rescue(self, where: str, start: Array) -> tuple[Trajectory, Trajectory, Trajectory]:
        """The motion after a failed phase: stay, rise to the greatest height of the task, and return home.

        Raises:
            InputError: if the arm cannot do it.
        """
        X_WTool = tool_pose(self._arm.plant, self._arm.tool, start)
        goals = [self._goal(phase) for phase in self._task.phases if phase.to in ("object", "goal")]
        rise = max((X_WGoal.translation()[2] for X_WGoal in goals), default=-np.inf) - X_WTool.translation()[2]
        wait_motion = rise_motion = self._timed(where, joint_path(start, start), 1.0)
        if rise > 0:
            X_WRaised = RigidTransform([0.0, 0.0, rise]) @ X_WTool
            rise_motion = self._to_pose(where, PhaseConfig(to="straight up", straight=True), X_WRaised, start)
        return wait_motion, rise_motion, self._timed(where, joint_path(end_of(rise_motion), self._arm.home), 1.0)

    def _goal(self, config: PhaseConfig) -> RigidTransform:
        """The goal pose of the gripper in the world."""
        task = self._task
        to_object = config.to == "object"
        X_WO = reported_pose(task, self._models) if to_object else task.X_WGoal.GetDeterministicValue()
        return RigidTransform([0.0, 0.0, config.height]) @ X_WO @ task.X_OG.GetDeterministicValue()

    def _to_pose(self, where: str, config: PhaseConfig, X_WTool: RigidTransform, start: Array) -> Trajectory:
        plant, tool = self._arm.plant, self._arm.tool
        try:
            if config.straight:
                path = straight_path(plant, tool, start, X_WTool, coupled=self._arm.couplings)
            else:
                path = joint_path(start, self._posture(X_WTool, start))
        except UnreachableError as error:
            raise InputError(where, "to", config.to, f"is out of reach of the arm: {error}") from None
        return self._timed(where, path, config.speed)

    def _posture(self, X_WTool: RigidTransform, start: Array) -> Array:
        posture = solve_posture(self._arm.plant, self._arm.tool, X_WTool, start, self._arm.couplings)
        if posture is None:
            raise UnreachableError(f"no posture places the gripper at {X_WTool.translation().round(3).tolist()} m")
        return posture

    def _timed(self, where: str, path: Trajectory, speed: float) -> Trajectory:
        try:
            return timed(self._arm.plant, path, self._limits, speed, self._arm.couplings)
        except LimitError as error:
            raise InputError(where, "motion", self._arm.name, f"exceeds the limits of the arm: {error}") from None


def make_task_machine(task: TaskConfig, models: Sequence[ModelConfig], arm: Arm, period: float) -> TaskMachine:
    """The controller of a task, which samples every `period` s.

    Raises:
        InputError: if the arm cannot reach the goal of a phase.
    """
    rules = Rules(plan_phases(task, models, arm), task.grip_threshold, task.timeout, task.quiet_band)
    return TaskMachine(rules, period)


def add_task(
    builder: DiagramBuilder,
    task: TaskConfig,
    models: Sequence[ModelConfig],
    arm: Arm,
    period: float,
    desired_state: InputPort,
    grip: tuple[InputPort, OutputPort, OutputPort] | None,
) -> tuple[TaskMachine, dict[str, OutputPort]]:
    """Adds `task`, which commands the `desired_state` of the arm every `period` s; returns it and the signals.

    `grip` are the set point, opening and torque of the grip control, if the task commands the gripper.

    Raises:
        InputError: if the arm cannot reach the goal of a phase.
    """
    machine = builder.AddNamedSystem("task", make_task_machine(task, models, arm, period))
    builder.Connect(machine.GetOutputPort("desired_state"), desired_state)
    signals = {f"task.{name}": machine.GetOutputPort(name) for name in ("phase", "outcome", "desired_state")}
    if grip is not None:
        set_point, opening, torque = grip
        builder.Connect(opening, machine.GetInputPort("opening"))
        builder.Connect(torque, machine.GetInputPort("torque"))
        builder.Connect(machine.GetOutputPort("set_point"), set_point)
        signals["grip.set_point"] = machine.GetOutputPort("set_point")
    return machine, signals


def add_tool_target(
    builder: DiagramBuilder, plant: MultibodyPlant, arm: Arm, period: float, desired_state: InputPort
) -> External:
    """Adds `{arm}.tool_follower`.

    Returns:
        the input port `{arm}.X_WTool`, a RigidTransform, the pose of the frame at which the gripper is welded; and
        `{arm}.desired_state`, the desired state of the joints, (2 n).

    Raises:
        InputError: if the arm's file does not give a limit.
    """
    try:
        limits = ArmLimits.of_plant(arm.plant, arm.config.acceleration)
    except LimitError as error:
        raise InputError("arm", "model", arm.name, str(error)) from None
    follower = ToolFollower(arm.plant, arm.tool, limits, period, arm.couplings)
    builder.AddNamedSystem(f"{arm.name}.tool_follower", follower)
    builder.Connect(plant.get_state_output_port(arm.model), follower.GetInputPort("robot_state"))
    builder.Connect(follower.GetOutputPort("desired_state"), desired_state)
    target = follower.GetInputPort("X_WTool")
    desired = follower.GetOutputPort("desired_state")
    return External({f"{arm.name}.X_WTool": target}, {f"{arm.name}.desired_state": desired})
