"""The phases of a task, planned before anything moves: where the arm goes, how fast, and what follows a failure."""

import math
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform
from pydrake.trajectories import Trajectory

from soft_gripper.arrays import Array
from soft_gripper.control.arm_kinematics import solve_posture, tool_pose
from soft_gripper.control.arm_motion import (
    ArmLimits,
    LimitError,
    UnreachableError,
    joint_path,
    straight_path,
    timed,
)
from soft_gripper.control.task_phases import Phase
from soft_gripper.diagrams.manipulation.arm import Arm
from soft_gripper.diagrams.manipulation.path_check import reported_pose
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario import ModelConfig, PhaseConfig, TaskConfig

RESCUE = ("rescue: open", "rescue: rise", "rescue: home")


def plan_phases(task: TaskConfig, models: Sequence[ModelConfig], arm: Arm) -> tuple[Phase, ...]:
    """The phases of the task, and behind them a rescue for each that can fail: fingers open, straight up, home.

    Raises:
        InputError: naming the phase whose goal the arm cannot reach, or not in the way that is asked for.
    """
    planner, configs = MotionPlanner(task, models, arm), task.phases
    watched = [i for i, config in enumerate(configs) if config.holds or config.until]
    end = len(configs) + len(RESCUE) * len(watched)
    phases: list[Phase] = []
    posture, opening = arm.home, math.nan
    for i, config in enumerate(configs):
        motion = planner.motion(f"task.phases[{i}] '{config.name}'", config, posture)
        posture, opening = end_of(motion), opening if config.opening is None else config.opening
        follower = i + 1 if i + 1 < len(configs) else end
        rescue = len(configs) + len(RESCUE) * watched.index(i) if i in watched else None
        phases.append(Phase(config.name, motion, opening, follower, config.until, config.rest, config.holds, rescue))
    for i in watched:
        motions = planner.rescue(f"task.phases[{i}] '{configs[i].name}', its rescue", end_of(phases[i].motion))
        for name, motion in zip(RESCUE, motions, strict=True):
            follower = end if name == RESCUE[-1] else len(phases) + 1
            until = "released" if name == RESCUE[0] else None
            phases.append(Phase(name, motion, phases[0].opening, follower, until))
    return tuple(phases)


def end_of(motion: Trajectory) -> Array:
    """The posture in which a motion ends, (n) rad or m."""
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
        """What the arm does in a phase that begins in the posture `start`.

        Raises:
            InputError: if it cannot.
        """
        if config.posture is not None:
            if len(config.posture) != len(start):
                raise InputError(where, "posture", config.posture, f"give {len(start)} numbers, one a joint of the arm")
            return self._timed(where, joint_path(start, np.array(config.posture)), config.speed)
        if config.to == "home":
            return self._timed(where, joint_path(start, self._arm.home), config.speed)
        if config.to is not None:
            return self._to_pose(where, config, self._goal(config), start)
        return self._timed(where, joint_path(start, start), config.speed)

    def rescue(self, where: str, start: Array) -> tuple[Trajectory, Trajectory, Trajectory]:
        """What is done from the end of a phase that failed: stay, rise as high as the task goes, and home.

        Raises:
            InputError: if the arm cannot.
        """
        X_WTool = tool_pose(self._arm.plant, self._arm.tool, start)
        goals = [self._goal(phase) for phase in self._task.phases if phase.to in ("object", "goal")]
        rise = max((X_WGoal.translation()[2] for X_WGoal in goals), default=-np.inf) - X_WTool.translation()[2]
        stay = up = self._timed(where, joint_path(start, start), 1.0)
        if rise > 0:
            above = RigidTransform([0.0, 0.0, rise]) @ X_WTool
            up = self._to_pose(where, PhaseConfig(to="straight up", straight=True), above, start)
        return stay, up, self._timed(where, joint_path(end_of(up), self._arm.home), 1.0)

    def _goal(self, config: PhaseConfig) -> RigidTransform:
        """Where the gripper is to be, in the world."""
        task = self._task
        to_object = config.to == "object"
        X_WO = reported_pose(task, self._models) if to_object else task.X_WGoal.GetDeterministicValue()
        return RigidTransform([0.0, 0.0, config.height]) @ X_WO @ task.X_OG.GetDeterministicValue()

    def _to_pose(self, where: str, config: PhaseConfig, X_WTool: RigidTransform, start: Array) -> Trajectory:
        plant, tool = self._arm.plant, self._arm.tool
        try:
            if config.straight:
                path = straight_path(plant, tool, start, X_WTool)
            else:
                path = joint_path(start, self._posture(X_WTool, start))
        except UnreachableError as error:
            raise InputError(where, "to", config.to, f"is out of the arm's reach: {error}") from None
        return self._timed(where, path, config.speed)

    def _posture(self, X_WTool: RigidTransform, start: Array) -> Array:
        posture = solve_posture(self._arm.plant, self._arm.tool, X_WTool, start)
        if posture is None:
            raise UnreachableError(f"no posture puts the gripper at {X_WTool.translation().round(3).tolist()} m")
        return posture

    def _timed(self, where: str, path: Trajectory, speed: float) -> Trajectory:
        try:
            return timed(self._arm.plant, path, self._limits, speed)
        except LimitError as error:
            raise InputError(where, "motion", self._arm.name, f"is more than the arm can do: {error}") from None
