"""The plant of a scenario, and the arm in it, without a station."""

from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.arm import Arm, make_arm
from soft_gripper.diagrams.scene import Scene, add_plant
from soft_gripper.scenario.schema import Scenario


def add_scene(builder: DiagramBuilder, scenario: Scenario) -> Scene:
    """Adds what a scenario simulates."""
    return add_plant(builder, scenario.plant_config, scenario.models, scenario.gravity, scenario.arm)


def arm_of(scenario: Scenario, scene: Scene) -> Arm:
    """The arm of a scenario that has one."""
    assert scenario.arm is not None
    return make_arm(scene.plant, scenario.models, scenario.arm, scene.fingers)
