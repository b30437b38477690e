"""EstimateScene: estimated fingers in Meshcat, without a simulation.

Only bodies of known pose are drawn: fixed ones, and fingers.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import PassThrough

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import Scene, add_plant
from soft_gripper.diagrams.view.finger_drawing import drawn_signals
from soft_gripper.diagrams.view.meshcat_view import add_estimates, set_up_view
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import ModelConfig, Scenario
from soft_gripper.sensors.sensor_block import joints_port

_ESTIMATES_PATH = "/drake"  # Meshcat path


class EstimateScene:
    """Draws the fingers of a scenario at their estimated joint angles, with bands, forces and torques.

    A finger with unknown joint angles keeps its last ones.
    """

    def __init__(
        self, scenario: Scenario, signals: Mapping[str, OutputPort], moving: Collection[str], meshcat: Meshcat
    ):
        """
        Args:
            scenario: of the fingers.
            signals: the ports of their estimation, by name, whose values `show` takes.
            moving: names of the fingers whose base moves; `{finger}.X_WB` of one of them places all fingers.
            meshcat: shows the scene.
        """
        self._meshcat = meshcat
        builder = DiagramBuilder()
        full_scene = add_plant(DiagramBuilder(), scenario)
        drawn = replace(scenario, models=_placed_models(scenario.models, full_scene.fingers, bool(moving)))
        scene = add_plant(builder, replace(drawn, arm=None, directives=[]) if moving else drawn)
        self._sizes = {
            name: signals[name].size() for finger in scene.fingers for name in _drawn_names(finger.name, signals)
        }
        inputs = {name: _add_input(builder, name, size) for name, size in self._sizes.items()}
        add_estimates(builder, scene, inputs, meshcat, scenario.pressure)
        set_up_view(full_scene, meshcat, scenario)
        self._positions = _estimated_positions(scene.fingers, signals)
        self._base = next((f for f in scene.fingers if f.name in moving), None)
        self._posed = _PosedScene(builder, scene)
        self.show({})

    @property
    def signals(self) -> list[str]:
        """Names of the drawn signals."""
        base = [] if self._base is None else [f"{self._base.name}.X_WB"]
        return [*self._sizes, *self._positions, *base]

    def show(self, values: Mapping[str, Array]) -> None:
        """Draws a sample, `signals` by name, (size,) each; missing ones are unknown."""
        for name, size in self._sizes.items():
            self._posed.give(name, values.get(name, np.full(size, np.nan)))
        for name, indices in self._positions.items():
            if np.isfinite(estimate := values.get(name, np.nan)).all():
                self._posed.positions[indices] = estimate
        if self._base is not None and f"{self._base.name}.X_WB" in values:
            R_p = values[f"{self._base.name}.X_WB"].reshape(3, 4)
            X_WB = RigidTransform(RotationMatrix.ProjectToRotationMatrix(R_p[:, :3]), R_p[:, 3])
            self._meshcat.SetTransform(_ESTIMATES_PATH, X_WB @ self._base.X_WB.inverse())
        self._posed.draw()


class _PosedScene:
    """Scene drawn at required positions; no time passes in its diagram."""

    def __init__(self, builder: DiagramBuilder, scene: Scene):
        self._diagram = builder.Build()
        self._plant = scene.plant
        self._is_initialized = False
        self._context = self._diagram.CreateDefaultContext()
        self._plant_context = scene.plant.GetMyMutableContextFromRoot(self._context)
        self.positions: Array = scene.plant.GetPositions(self._plant_context).copy()

    def give(self, name: str, value: Array) -> None:
        """Sets an input of the diagram."""
        self._diagram.GetInputPort(name).FixValue(self._context, value)

    def draw(self) -> None:
        self._plant.SetPositions(self._plant_context, self.positions)
        if not self._is_initialized:
            self._diagram.ExecuteInitializationEvents(self._context)
            self._is_initialized = True
        self._diagram.ForcedPublish(self._context)


def _placed_models(models: Sequence[ModelConfig], fingers: Sequence[PlantFinger], is_moving: bool) -> list[ModelConfig]:
    """Models with a known pose: fixed ones; of moving fingers, the grippers alone, in their own frames."""
    if not is_moving:
        return [model for model in models if not model.free]
    grippers = {finger.model_name for finger in fingers}
    gripper_models = [model for model in models if model.name in grippers]
    return [m if m.parent.partition("::")[0] in grippers else replace(m, parent="world") for m in gripper_models]


def _drawn_names(finger: str, signals: Collection[str]) -> list[str]:
    """Names of the drawn signals of a finger."""
    names = [name.removeprefix(f"{finger}.") for name in signals if name.startswith(f"{finger}.")]
    return [f"{finger}.{name}" for name in ("arcs", "external_torque", *drawn_signals(names))]


def _estimated_positions(fingers: Sequence[PlantFinger], signals: Mapping[str, OutputPort]) -> dict[str, list[int]]:
    """Indices of the plant's positions that a signal of joint estimates sets."""
    return {
        name: [joint.position_start() for joint in finger.joints_of(deformation)]
        for finger in fingers
        for deformation in finger.finger.yields
        if (name := f"{finger.name}.estimated_{joints_port(deformation)}") in signals
    }


def _add_input(builder: DiagramBuilder, name: str, size: int) -> OutputPort:
    block = builder.AddNamedSystem(name, PassThrough(size))
    builder.ExportInput(block.get_input_port(), name)
    return block.get_output_port()
