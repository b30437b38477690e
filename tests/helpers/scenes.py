"""The plant of a scenario: states of it to take pictures of, and where in them Drake says that things are."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr
from pydrake.systems.framework import DiagramBuilder
from scenario_plants import add_scene

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.fingers.finger_links import joint_name
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.scenario.scenario_file import load_scenario

NO_TORQUE = np.zeros(12)  # N m


class Scene:
    """The plant of a scenario: states of it to take pictures of, and where in them Drake says that things are."""

    def __init__(self, name: str):
        self.scenario = load_scenario(name)
        self.plant, _, fingers, *_ = add_scene(DiagramBuilder(), self.scenario)
        self.fingers = [finger.name for finger in fingers]
        self.context = self.plant.CreateDefaultContext()

    def bend(self, finger: str, angle: float) -> None:
        for i in range(12):
            self.plant.GetJointByName(joint_name(finger, i)).set_angle(self.context, angle)

    def move(self, body: str, shift: Array) -> None:
        free = self.plant.GetBodyByName(body)
        X_WB = free.EvalPoseInWorld(self.context)
        X_WB.set_translation(X_WB.translation() + shift)
        self.plant.SetFreeBodyPose(self.context, free, X_WB)

    def point(self, frame: str, p_F: Any = (0.0, 0.0, 0.0)) -> Array:
        return self.plant.GetFrameByName(frame).CalcPoseInWorld(self.context) @ np.array(p_F)

    def state(self) -> Array:
        return np.array(self.plant.GetPositionsAndVelocities(self.context))

    def pose_arm(self, posture: Sequence[float]) -> None:
        assert self.scenario.arm is not None
        arm = self.plant.GetModelInstanceByName(self.scenario.arm.model)
        self.plant.SetPositions(self.context, arm, posture)

    def recording(
        self, *states: Array, torques: Array = NO_TORQUE, signals: Mapping[str, Sequence[float]] | None = None
    ) -> Recording:
        """A state a second, signals beside it, and the same torques all the time."""
        variables: dict[str, Any] = {f"{finger}.true_external_torque": ("joint", torques) for finger in self.fingers}
        variables |= {name: ("time", np.array(values)) for name, values in (signals or {}).items()}
        data = xr.Dataset({"plant.state": (("time", "state"), np.array(states))} | variables)
        return Recording(data.assign_coords(time=np.arange(len(states), dtype=float)))

    def renderer(self, *states: Array, torques: Array = NO_TORQUE, limit: float | None = None) -> SceneRenderer:
        return SceneRenderer(self.scenario, self.recording(*states, torques=torques), 120, 160, limit)
