"""SoftGripperEnv: an environment file as a Gymnasium environment, whose station is simulated in Drake.

The time limit is the environment's own rather than Gymnasium's TimeLimit: it is in the file, next to the step.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
from gymnasium import Env
from numpy.typing import NDArray
from pydrake.geometry import Meshcat, MeshcatParams
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.view.meshcat_view import LOOPBACK
from soft_gripper.errors import InputError, first_line
from soft_gripper.extras.learning.agent_inputs import (
    check_options,
    check_order,
    check_rendered,
    finite_actions,
    integer_seed,
)
from soft_gripper.extras.learning.config import Environment, load_environment
from soft_gripper.extras.learning.episode_variation import Draw, apply_draw, varied_fingers
from soft_gripper.extras.learning.episodes import Episodes, Rows
from soft_gripper.extras.learning.station import home, make_learning_station, resting_action
from soft_gripper.fingers.kinematics import as_planar, in_space

MODES = ("human", "rgb_array")
Vector = NDArray[np.float32]
_NO_ROWS: Rows = np.zeros(0, int)  # no environment restarts


class SoftGripperEnv(Env[Vector, Vector]):
    """Environment in which actions from -1 to 1 command a station, and observations are estimates from its sensors.

    Episodes vary parameters in the context of a built diagram; springs of fingers cannot vary there, so several
    grippers are built once. The ground truth is in the reward and in `info` only. After `duration` an episode is
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
        self.environment, self.render_mode = load_environment(environment, changes), render_mode
        config = self.environment.config
        self._station = DrakeStation(self.environment, render_mode)
        self._episodes = Episodes(config, self._station, 1)
        self.action_space, self.observation_space = self._episodes.action_space, self._episodes.observation_space
        self.metadata = {"render_modes": [*MODES], "render_fps": round(1 / config.time_step)}
        self._is_begun = self._is_closed = False

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Vector, dict[str, Any]]:
        """Begins an episode.

        Raises:
            InputError: if the seed is no integer from 0 to 2^64 - 1, options are given, as there are none, or the
                environment is closed.
        """
        check_order("reset", is_begun=True, is_closed=self._is_closed)
        check_options(options)
        super().reset(seed=integer_seed(seed))
        (observation,), (episode_draw,) = self._episodes.begin([self.np_random])
        self._is_begun = True
        return observation, asdict(episode_draw)

    def step(self, action: Any) -> tuple[Vector, float, bool, bool, dict[str, Any]]:
        """Applies an action for a time step.

        Raises:
            InputError: if the action is not finite, or has another shape than `action_space`; or before a reset, or
                after `close`.
        """
        self._check_begun("step")
        numbers = finite_actions(action, "action", self._station.resting.shape)
        result = self._episodes.step(np.clip(numbers, -1.0, 1.0)[None], _NO_ROWS, [self.np_random])
        (observation,), (reason,) = result.observed, result.diverged
        reward, *ends = (values.item() for values in (result.reward, result.terminated, result.truncated))
        info = {"diverged": reason} if reason else {name: _to_scalar(value[0]) for name, value in result.info.items()}
        return observation, reward, *ends, info

    def render(self) -> NDArray[np.uint8] | None:
        """The scene as a picture, (height, width, 3), or in Meshcat.

        Raises:
            InputError: before a reset, after `close`, or without a `render_mode`.
        """
        self._check_begun("render")
        check_rendered(self.render_mode, MODES)
        if self.render_mode == "rgb_array":
            return self._station.picture()
        self._station.show()
        return None

    def close(self) -> None:
        """Closes the environment."""
        self._is_closed = True

    def _check_begun(self, act: str) -> None:
        check_order(act, self._is_begun, self._is_closed)


def _to_scalar(value: Any) -> Any:
    """Converts a number of numpy to one of Python; arrays stay."""
    return value if np.ndim(value) else value.item()


def open_meshcat() -> Meshcat:
    """A Meshcat at the first free port of its default range, for this machine only.

    Raises:
        InputError: if none is free.
    """
    try:
        return Meshcat(MeshcatParams(host=LOOPBACK))
    except RuntimeError as error:
        expected = f"no free port at {LOOPBACK}; close other viewers ({first_line(error)})"
        raise InputError("Meshcat", "port", "7000 to 7099", expected) from None


class DrakeStation:
    """Station of one environment, see `Stations`: one of a few grippers, chosen by the episode."""

    def __init__(self, environment: Environment, render_mode: str | None):
        """`render_mode`: see `SoftGripperEnv`."""
        self._config = config = environment.config
        meshcat, self._grippers = open_meshcat() if render_mode == "human" else None, []
        for number in range(config.variation.grippers):
            scenario = varied_fingers(environment.scenario, config.variation, number)
            station = make_learning_station(config, scenario, render_mode == "rgb_array", meshcat)
            simulator = Simulator(station.diagram)
            ApplySimulatorConfig(solver_config(scenario), simulator)
            if meshcat is not None:
                simulator.set_target_realtime_rate(1.0)
            self._grippers.append((station, simulator))
        self.station, self.simulator = self._grippers[0]
        self.resting = resting_action(config.action, home(self.station.parts))
        self._act(self.resting)

    def begin(self, rows: Rows, draws: Sequence[Draw], task_draws: Array) -> None:
        self.station, self.simulator = self._grippers[draws[0].gripper]
        context = self.simulator.get_mutable_context()
        self.station.diagram.SetDefaultContext(context)
        self._act(self.resting)
        apply_draw(self.station, context, draws[0])
        self.station.follow(context, task_draws[0])
        context.SetTime(0.0)
        self.simulator.Initialize()

    def step(self, actions: Array) -> list[str]:
        self._act(actions[0])
        context = self.simulator.get_mutable_context()
        reason = ""
        try:
            self.simulator.AdvanceTo(context.get_time() + self._config.time_step)
        except (RuntimeError, SystemExit) as error:  # the latter comes from failed conditions of Drake
            reason = first_line(error)
        plant = self.station.parts.plant
        if not reason and not np.isfinite(plant.GetPositionsAndVelocities(self._plant_context)).all():
            reason = "the state is no longer finite"
        if reason:
            self.station.diagram.SetDefaultContext(context)  # a diverged context cannot be read
        return [reason]

    def observe(self) -> Array:
        observation: Array = self.station.diagram.GetOutputPort("observation").Eval(self.simulator.get_context())
        return observation[None]

    def object_places(self) -> Array:
        assert self.station.object is not None
        return np.array([self.station.object.EvalPoseInWorld(self._plant_context).translation()])

    def normal_forces(self) -> tuple[Array, Array]:
        forces = self.station.forces
        assert forces is not None
        context = forces.GetMyContextFromRoot(self.simulator.get_context())
        force, peak_force = (forces.GetOutputPort(name).Eval(context) for name in ("force", "peak"))
        return force[None], np.array([max(peak_force.max(), force.max())])

    def tip_errors(self) -> Array:
        target, finger = self.station.target, self.station.parts.fingers[0]
        assert target is not None
        goal = target.get_output_port().Eval(target.GetMyContextFromRoot(self.simulator.get_context()))
        tip = finger.frames[-1].CalcPose(self._plant_context, finger.base.body_frame()).translation()
        return np.array([np.linalg.norm(tip - in_space(as_planar(goal)))])

    def picture(self) -> NDArray[np.uint8]:
        """The scene, (height, width, 3)."""
        image = self.station.diagram.GetOutputPort("picture").Eval(self.simulator.get_context())
        return np.array(image.data[:, :, :3])

    def show(self) -> None:
        """Shows the scene in Meshcat."""
        self.station.diagram.ForcedPublish(self.simulator.get_context())

    @property
    def _plant_context(self) -> Context:
        return self.station.parts.plant.GetMyContextFromRoot(self.simulator.get_context())

    def _act(self, action: Array) -> None:
        self.station.diagram.GetInputPort("action").FixValue(self.simulator.get_mutable_context(), action)
