"""SoftGripperVectorEnv: many environments of one file at once, in MuJoCo, as a vector environment of Gymnasium.

Observations and rewards are those of `SoftGripperEnv`, by the same blocks and functions, with the environments as
leading axis. MuJoCo takes contact at points, as the shipped scenes do in Drake.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.extras.learning.agent_inputs import (
    check_options,
    check_order,
    check_rendered,
    finite_actions,
    integer_seeds,
)
from soft_gripper.extras.learning.config import EnvironmentConfig, load_environment
from soft_gripper.extras.learning.episode_variation import Draw, varied_fingers
from soft_gripper.extras.learning.episodes import Episodes, Rows
from soft_gripper.extras.learning.station import (
    FORCE_PERIOD,
    Observation,
    home,
    make_learning_station,
    resting_action,
)
from soft_gripper.extras.mujoco_engine.blocks import direct, side_by_side
from soft_gripper.extras.mujoco_engine.engine import LONGEST_STEP, dividing_step
from soft_gripper.extras.mujoco_engine.network import Network
from soft_gripper.extras.mujoco_engine.normal_forces import NormalForces
from soft_gripper.extras.mujoco_engine.plants import Exported, Plants, export_to_mujoco
from soft_gripper.extras.mujoco_engine.variation import Variation, begin_positions, vary_model
from soft_gripper.files.document import check_config
from soft_gripper.quantity import valid
from soft_gripper.scenario.schema import Scenario


@dataclass(frozen=True)
class _Copies:
    """Numbers of environments, and of threads that step them."""

    num_envs: int = field(metadata=valid(least=1, most=2**16))
    threads: int = field(metadata=valid(least=1, most=2**10))


class SoftGripperVectorEnv(VectorEnv[Any, Any, Any]):
    """Agents act on stations from -1 to 1, and observe estimates from the sensors of the grippers.

    An episode that has ended restarts in the next step, whose action is ignored. A seed gives the same object and
    sensors as in `SoftGripperEnv`, but the grippers' moduli alternate among the environments. A simulation that
    diverges truncates its episode: `info["diverged"]`.
    """

    def __init__(
        self,
        num_envs: int = 1,
        environment: str = "soft_grasp",
        changes: Mapping[str, Any] | None = None,
        threads: int = 1,
    ):
        """Builds the stations.

        Args:
            num_envs: number of environments, at most 65536.
            environment: name of a shipped environment, or path of a file; see `load_environment`.
            changes: of it.
            threads: number of threads that step the plants, at most 1024.

        Raises:
            InputError: if a number or anything in the file is invalid, or the task handles no object.
        """
        check_config("vector environment", _Copies(num_envs, threads))
        self.environment = load_environment(environment, changes)
        config = self.environment.config
        if config.grasp is None and config.pick_place is None:
            expected = "handles no object; use vectorization_mode='async', whose environments are simulated in Drake"
            raise InputError("vector environment", "environment", environment, expected)
        self.num_envs, self.metadata = num_envs, {"autoreset_mode": AutoresetMode.NEXT_STEP}
        scenario = replace(self.environment.scenario, engine="mujoco")
        self._stations = MujocoStations(config, scenario, num_envs, threads)
        self._episodes = Episodes(config, self._stations, num_envs)
        self.single_action_space = self._episodes.action_space
        self.single_observation_space = self._episodes.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self._random = [np_random(None)[0] for _ in range(num_envs)]
        self._has_ended, self._is_begun = np.zeros(num_envs, bool), False

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        """Begins an episode in all environments; seeds of environments follow each other if one is given.

        Raises:
            InputError: if a seed is no integer from 0 to 2^64 - 1, there are fewer or more than environments, options
                are given, as there are none, or the environments are closed.
        """
        check_order("reset", is_begun=True, is_closed=self.closed)
        check_options(options)
        for i, own_seed in enumerate(integer_seeds(seed, self.num_envs)):
            if own_seed is not None:
                self._random[i] = np_random(own_seed)[0]
        observations, _ = self._episodes.begin(self._random)
        self._has_ended[:], self._is_begun = False, True
        return observations, {}

    def step(
        self, actions: Any
    ) -> tuple[NDArray[np.float32], NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """Applies actions for a time step.

        Raises:
            InputError: if the actions are not finite, or have another shape than `action_space`; or before a reset, or
                after `close`.
        """
        check_order("step", self._is_begun, self.closed)
        shape = self.action_space.shape
        assert shape is not None
        numbers = finite_actions(actions, "actions", shape)
        is_anew = self._has_ended.copy()
        result = self._episodes.step(np.clip(numbers, -1.0, 1.0), np.flatnonzero(is_anew), self._random)
        info = result.info | {"diverged": np.array([bool(reason) for reason in result.diverged])}
        self._has_ended = result.terminated | result.truncated
        masks = {f"_{name}": ~is_anew for name in info}
        return result.observed, result.reward, result.terminated, result.truncated, info | masks

    def render(self) -> tuple[Any, ...] | None:
        """Raises an InputError: these environments are not rendered."""
        check_order("render", self._is_begun, self.closed)
        check_rendered(self.render_mode, ())
        return None


_NOT_FINITE = "the state is no longer finite"


class MujocoStations:
    """Stations of many environments, see `Stations`; their grippers alternate."""

    def __init__(self, config: EnvironmentConfig, scenario: Scenario, count: int, threads: int):
        self._config = config
        grippers = [varied_fingers(scenario, config.variation, i) for i in range(min(count, config.variation.grippers))]
        learning = [make_learning_station(config, gripper, composed=False) for gripper in grippers]
        stations = [Station(station.diagram, station.parts, None) for station in learning]  # type: ignore[arg-type]  # without logs
        self._learning, self._station = learning[0], stations[0]
        self._period, self._plant_step = scenario.sensor.period, self._station.plant.time_step()
        self._check_scenario(scenario)
        step = dividing_step(self._plant_step, scenario.engine_step or LONGEST_STEP)
        self._substeps = round(self._plant_step / step)
        object_task = config.grasp or config.pick_place
        assert object_task is not None
        assert self._learning.object is not None
        self._name, self._body = object_task.object, self._learning.object
        self._sensors = NormalForces(self._station)
        exported = [export_to_mujoco(station, step, [self._name], self._sensors) for station in stations]
        station_numbers = np.arange(count) % len(stations)
        self._exported: list[Exported] = [exported[i] for i in station_numbers]
        begins = np.tile(begin_positions(self._station.plant, Variation()), (count, 1))
        models = [station.model for station in self._exported]
        self._plants = Plants(self._station, exported[0].touching, models, begins, threads)
        graphs = {Observation: lambda block: direct(block, lambda *signals: block.observe(side_by_side(*signals)))}
        station_turns = [stations[i] for i in station_numbers]
        self._network = Network(station_turns, self._plants, None, ["observation"], graphs)
        self.resting = resting_action(config.action, home(self._learning.parts))
        self._actions = np.tile(self.resting, (count, 1))
        self._network.give("action", self._actions)
        self._network.begin()
        self._place = self._body.floating_positions_start() + 4
        self._goals = np.zeros((count, 1))
        self._force: Array = np.zeros((count, len(self._station.fingers)))
        self._peak: Array = np.zeros(count)

    def _check_scenario(self, scenario: Scenario) -> None:
        for name, period in (("plant_config.time_step", self._plant_step), ("sensor.period", self._period)):
            steps = self._config.time_step / period if period else 0.0
            if not steps or abs(steps - round(steps)) > 1e-6:
                expected = f"must divide time_step, {self._config.time_step:g} s"
                raise InputError("vector environment", name, period, expected)

    def begin(self, rows: Rows, draws: Sequence[Draw], task_draws: Array) -> None:
        variations = [self._variation(draw) for draw in draws]
        plant, points = self._station.plant, self._station.scenario.contact_points
        exported = [self._exported[i] for i in rows]
        pairs = zip(exported, variations, strict=True)
        models = [vary_model(copy.model, copy.pairs, plant, variation, points) for copy, variation in pairs]
        self._plants.reset(rows, models, np.array([begin_positions(plant, variation) for variation in variations]))
        self._actions[rows] = self.resting
        self._network.give("action", self._actions)
        self._network.begin(rows, [draw.sensor_seed for draw in draws])
        self._force[rows], self._peak[rows] = 0.0, 0.0
        if self._config.pick_place is not None:
            self._goals[rows] = task_draws
            self._network.give("goal", self._goals)

    def observe(self) -> Array:
        return self._network.read("observation")

    def object_places(self) -> Array:
        return self._plants.state[:, self._place : self._place + 3]

    def normal_forces(self) -> tuple[Array, Array]:
        return self._force, self._peak

    def tip_errors(self) -> Array:
        raise NotImplementedError  # environments without an object are refused

    def _variation(self, draw: Draw) -> Variation:
        name, X_WO = self._name, self._station.plant.GetDefaultFloatingBaseBodyPose(self._body)
        size = draw.size or 1.0
        shift = np.array([draw.offset, 0.0, (size - 1) * self._learning.object_height])
        changes = {"masses": draw.mass, "frictions": draw.friction, "sizes": draw.size, "stiffnesses": draw.stiffness}
        fields = {field: {name: value} for field, value in changes.items() if value is not None}
        return Variation({name: RigidTransform(X_WO.rotation(), X_WO.translation() + shift)}, **fields)

    def step(self, actions: Array) -> list[str]:
        self._actions[:] = actions
        self._network.give("action", self._actions)
        plants, network, plant_step = self._plants, self._network, self._plant_step
        stride = round(self._period / plant_step)
        for first_step in range(0, round(self._config.time_step / plant_step), stride):
            network.drive_plants(first_step * plant_step)
            plants.begin_step(keeps=True)
            network.sample()
            plants.finish_step(keeps=True)
            network.step([i * plant_step for i in range(first_step + 1, first_step + stride)], keeps=True)
        self._update_forces()
        plants.look()
        return ["" if is_finite else _NOT_FINITE for is_finite in np.isfinite(plants.state).all(axis=1)]

    def _update_forces(self) -> None:
        """Updates the normal forces on the fingers at the end of a step, (E, F) N, and their largest samples, (E) N."""
        forces = self._sensors.read(
            self._plants.take_readings(self._substeps * max(1, round(FORCE_PERIOD / self._plant_step)))
        )
        self._force = forces[:, -1]
        self._peak = np.maximum(self._peak, forces.max(axis=(1, 2)))
