"""SoftGripperEnv: an environment file as a Gymnasium environment, through Drake's DrakeGymEnv.

The time limit is the environment's own rather than Gymnasium's TimeLimit: it is in the file, next to the step.
"""

import warnings
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
from gymnasium.spaces import Box
from numpy.typing import NDArray
from pydrake.common import RandomGenerator
from pydrake.geometry import Meshcat
from pydrake.gym import DrakeGymEnv
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context, System

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.view.meshcat_view import open_meshcat
from soft_gripper.errors import InputError, first_line
from soft_gripper.extras.learning.agent_inputs import (
    check_options,
    check_order,
    check_rendered,
    finite_actions,
    integer_seed,
)
from soft_gripper.extras.learning.config import EnvironmentConfig, load_environment
from soft_gripper.extras.learning.episode_variation import Draw, apply_draw, draw, varied_fingers
from soft_gripper.extras.learning.station import LARGEST, LearningStation, home, make_learning_station, resting_action
from soft_gripper.extras.learning.tasks import Grasp, Judgement, PickPlace, Reach, Task

MODES = ("human", "rgb_array")
Vector = NDArray[np.float32]


class _Built(NamedTuple):
    """One of the grippers that episodes take."""

    simulator: Simulator
    station: LearningStation
    task: Task


class SoftGripperEnv(DrakeGymEnv):
    """An agent acts on a station from -1 to 1, and observes estimates from the sensors of the gripper.

    Episodes vary what can be set in the context of a built diagram; the springs of fingers cannot, so several grippers
    are built once. The ground truth is in the reward and in `info` only. After `duration` an episode is
    truncated; so is one whose simulation diverges: `info["diverged"]` says why, the observation is that of the step
    before, and the reward 0.
    """

    metadata: dict[str, Any] = {"render_modes": [*MODES], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self, environment: str = "soft_grasp", changes: Mapping[str, Any] | None = None, render_mode: str | None = None
    ):
        """Builds the stations.

        Args:
            environment: name of a shipped environment, or path of a file; see `load_environment`.
            changes: of it.
            render_mode: "human" (Meshcat, at real time), "rgb_array" or None.

        Raises:
            InputError: if anything in the file, or the mode, is invalid.
        """
        if render_mode not in (None, *MODES):
            raise InputError("environment", "render_mode", render_mode, f"known: {', '.join(MODES)}; or None")
        self.environment = load_environment(environment, changes)
        config = self.environment.config
        meshcat = open_meshcat() if render_mode == "human" else None
        self._pool = [self._build(i, render_mode, meshcat) for i in range(config.variation.grippers)]
        self._now, self._drawn = self._pool[0], Draw()
        self._judgement = Judgement(0.0, False, {})
        diagram = self._now.station.diagram
        self._resting = resting_action(config.action, home(self._now.station.parts))
        size = diagram.GetOutputPort("observation").size()
        self._observed: Vector = np.zeros(size, np.float32)
        self.metadata = {}  # a copy of its own: DrakeGymEnv writes into it
        super().__init__(
            simulator=self._begin,
            time_step=config.time_step,
            action_space=Box(-1.0, 1.0, (len(self._resting),), np.float32),
            observation_space=Box(-LARGEST, LARGEST, (size,), np.float32),
            reward=self._reward,
            action_port_id="action",
            observation_port_id="observation",
            render_rgb_port_id="picture" if render_mode == "rgb_array" else None,
            render_mode=render_mode,
            hardware=True,  # a reset keeps the context that `_begin` made: it would be initialized twice otherwise
        )
        self.metadata = {"render_modes": [*MODES], "render_fps": round(1 / config.time_step)}
        # The ground truth at the start of an episode; DrakeGymEnv drops a handler that is given to its constructor.
        self.info_handler = lambda _: asdict(self._drawn)
        self._is_closed = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Vector, dict[str, Any]]:
        """Begins an episode.

        Raises:
            InputError: if the seed is no integer from 0 to 2^64 - 1, options are given, as there are none, or the
                environment is closed.
        """
        check_order("reset", is_begun=True, is_closed=self._is_closed)
        check_options(options)
        observation, info = super().reset(seed=integer_seed(seed))
        self._observed = observation.astype(np.float32)
        return self._observed, info

    def step(self, action: Any) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        """Applies an action for a time step.

        Raises:
            InputError: if the action is not finite, or has another shape than `action_space`; or before a reset, or
                after `close`.
        """
        self._check_begun("step")
        numbers = finite_actions(action, "action", self.action_space.shape)
        reason = self._advance(np.clip(numbers, -1.0, 1.0))
        if reason:
            return self._observed, 0.0, False, True, {"diverged": reason}
        is_late = bool(self._now.simulator.get_context().get_time() > self.environment.config.duration - 1e-9)
        return self._observed, *self._judgement[:2], is_late, self._judgement.info

    def render(self) -> NDArray[np.uint8] | None:
        """The scene as a picture, (height, width, 3), or in Meshcat.

        Raises:
            InputError: before a reset, after `close`, or without a `render_mode`.
        """
        self._check_begun("render")
        check_rendered(self.render_mode, MODES)
        picture = super().render()
        return None if picture is None else picture.copy()  # Drake's own is overwritten by the next one

    def close(self) -> None:
        """Ends the use of the environment."""
        self._is_closed = True
        super().close()

    def _check_begun(self, act: str) -> None:
        check_order(act, is_begun=self.simulator is not None, is_closed=self._is_closed)

    def _advance(self, action: NDArray[np.float64]) -> str:
        """Takes a step; returns why it diverged, if it did."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", UserWarning)
            try:
                observation, *_, failed, _ = super().step(action)
            except (RuntimeError, SystemExit) as error:  # the latter comes from failed conditions of Drake
                return first_line(error)
        if failed:
            return str(caught[-1].message)
        plant, context = self._now.station.parts.plant, self._now.simulator.get_context()
        if not np.isfinite(plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(context))).all():
            return "the state is no longer finite"
        self._observed = observation.astype(np.float32)
        return ""

    def _build(self, number: int, render_mode: str | None, meshcat: Meshcat | None) -> _Built:
        config = self.environment.config
        scenario = varied_fingers(self.environment.scenario, config.variation, number)
        station = make_learning_station(config, scenario, render_mode == "rgb_array", meshcat)
        simulator = Simulator(station.diagram)
        ApplySimulatorConfig(solver_config(scenario), simulator)
        if meshcat is not None:
            simulator.set_target_realtime_rate(1.0)
        return _Built(simulator, station, make_task(station, config))

    def _begin(self, _: RandomGenerator) -> Simulator:
        """A simulator ready for an episode; DrakeGymEnv then initializes it."""
        self._drawn = draw(self.np_random, self.environment.config.variation)
        self._now = self._pool[self._drawn.gripper]
        simulator, station, task = self._now
        context = simulator.get_mutable_context()
        station.diagram.SetDefaultContext(context)
        station.diagram.GetInputPort("action").FixValue(context, self._resting)
        apply_draw(station, context, self._drawn)
        task.begin(context, self.np_random)
        return simulator

    def _reward(self, _: System, context: Context) -> float:
        self._judgement = self._now.task.judge(context)
        return self._judgement.reward


def make_task(station: LearningStation, config: EnvironmentConfig) -> Task:
    """The task of an environment, on one of its stations."""
    if config.reach is not None:
        return Reach(station, config.reach, config.time_step)
    if config.grasp is not None:
        return Grasp(station, config.grasp, config.time_step)
    assert config.pick_place is not None
    return PickPlace(station, config.pick_place, config.time_step)
