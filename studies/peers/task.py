"""Describes a task for any simulator, a scenario with pressures in steps, and the result of a run."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from soft_gripper import Scenario, expand_urdf, load_scenario, model_path
from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.wiring.drive import pressure_steps
from soft_gripper.fingers import Finger
from soft_gripper.fingers.urdf import ExpandedUrdf
from soft_gripper.scenario.schema import ModelConfig
from studies.peers.bodies import Body, scene_bodies

Setting = dict[str, Any]  # of a simulator, as in settings.yaml


class PeerTrial(NamedTuple):
    """A run, sampled at the end of every period of the sensors; T samples, F fingers."""

    seconds: float  # CPU time of stepping, and of sensing if requested
    tips: Planar  # (T, F) m, fingertips in their frames B
    held: Array  # (T, 3) m in the world, of the free body; (T, 0) where there is none


Run = Callable[[], PeerTrial]  # from the beginning, every time


@dataclass(frozen=True)
class PeerTask:
    """A scenario with pressures in steps; `sensed` requests strain, shape and external torque at every sample."""

    scenario: Scenario
    sensed: bool = False

    @cached_property
    def grippers(self) -> list[tuple[ModelConfig, ExpandedUrdf]]:
        """The models with fingers, as plain URDF."""
        urdf = [model for model in self.scenario.models if model.file.endswith(".urdf")]
        return [(model, expand_urdf(model_path(model.file), model.segments, model.name)) for model in urdf]

    @cached_property
    def fingers(self) -> list[Finger]:
        """Fingers in the order of the models."""
        return [finger for _, expanded in self.grippers for finger in expanded.fingers]

    @cached_property
    def bodies(self) -> list[Body]:
        """Bodies other than grippers, in their poses."""
        return scene_bodies(self.scenario)

    @property
    def grasped_body(self) -> Body | None:
        return next((body for body in self.bodies if body.is_free), None)

    def object_positions(self, recording: Recording) -> Array:
        """Positions of the grasped body after the first sample, (T, 3) m; (T, 0) without one."""
        if self.grasped_body is None:
            return np.zeros((recording.data.sizes["time"] - 1, 0))
        return recording[f"{self.grasped_body.name}.pose"].values[1:, -3:]

    @property
    def period(self) -> float:
        """Sampling period, s."""
        return self.scenario.sensor.period

    @cached_property
    def commands(self) -> Array:
        """Commanded pressures during every period, (T, F) Pa."""
        count = round(self.scenario.step_duration / self.period)
        return np.array([np.repeat(pressure_steps(self.scenario.pressure, f.name), count) for f in self.fingers]).T

    def pressures(self, substeps: int) -> Array:
        """Lagging pressures in the chambers in the middle of all substeps of every period, (T, substeps, F) Pa."""
        lag = self.scenario.pressure.time_constant
        decay = np.exp(-(np.arange(substeps) + 0.5) / substeps * self.period / lag)[:, None]
        last_pressures = np.zeros_like(self.commands)
        for i, command in enumerate(self.commands[:-1]):
            last_pressures[i + 1] = command + (last_pressures[i] - command) * np.exp(-self.period / lag)
        return self.commands[:, None] + (last_pressures - self.commands)[:, None] * decay

    def substeps(self, step: float) -> int:
        """Steps of `step` s in a period."""
        return round(self.period / step)


def load_task(spec: dict[str, Any], overrides: tuple[str, ...] = ()) -> PeerTask:
    """A task as settings.yaml describes it, with more overrides of its scenario."""
    return PeerTask(load_scenario(spec["scenario"], [*spec["overrides"], *overrides]), spec.get("sensed", False))
