"""Scenarios of a few models, and the plant of a scenario, and the arm in it, without a station."""

from pathlib import Path

from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.arm import Arm, make_arm
from soft_gripper.diagrams.scene import Scene, add_plant
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario


def scenario_of(folder: Path, *models: str) -> Scenario:
    """A scenario of models, each written as a line of YAML."""
    path = folder / "scenario.yaml"
    path.write_text("models:\n" + "".join(f"- {{{model}}}\n" for model in models), encoding="utf-8")
    return load_scenario(str(path))


def add_scene(builder: DiagramBuilder, scenario: Scenario) -> Scene:
    """Adds what a scenario simulates."""
    return add_plant(builder, scenario)


def arm_of(scenario: Scenario, scene: Scene) -> Arm:
    """The arm of a scenario that has one."""
    assert scenario.arm is not None
    return make_arm(scene.plant, scenario.models, scenario.arm, scene.fingers)
