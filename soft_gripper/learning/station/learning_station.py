"""make_learning_station: an environment -> a diagram with the ports `action` and `observation`, built once."""

from dataclasses import dataclass

from pydrake.geometry import Meshcat, Role
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantVectorSource

from soft_gripper.diagrams.scene import arm_joints, first_body
from soft_gripper.diagrams.station import add_station
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.diagrams.view.viewpoint import box_corners
from soft_gripper.learning.schema.config import EnvironmentConfig
from soft_gripper.learning.station.actions import add_action
from soft_gripper.learning.station.camera import add_camera
from soft_gripper.learning.station.observation import add_observation
from soft_gripper.learning.station.peak_force import PeakForce, add_peak_force
from soft_gripper.learning.station.tip_target import TipTarget, add_tip_target
from soft_gripper.scenario.scenario import Scenario
from soft_gripper.signals import describe


@dataclass(frozen=True)
class LearningStation:
    """A station that an agent acts on."""

    diagram: Diagram
    parts: StationParts
    forces: PeakForce
    seen: bool  # by a camera or in Meshcat
    object: RigidBody | None = None  # first body of what is handled
    object_height: float = 0.0  # m, of its frame over its lowest point
    target: TipTarget | None = None
    goal: ConstantVectorSource | None = None


def make_learning_station(
    config: EnvironmentConfig, scenario: Scenario, picture: bool = False, meshcat: Meshcat | None = None
) -> LearningStation:
    """Builds a diagram.

    ::

        action (n) ---> +---------+ ---> observation (k)
                        | station | ---> picture, if there is to be one
                        +---------+

    Args:
        config: of the environment.
        scenario: of this station; the commands that an action gives are left open.
        picture: whether a camera looks at the scene.
        meshcat: shows the scene and the estimates.

    Raises:
        InputError: if a part cannot be built, or does not fit the others.
    """
    builder = DiagramBuilder()
    parts = add_station(builder, scenario, meshcat)
    _add_action(builder, config, parts)
    forces = add_peak_force(builder, parts)
    target = goal = None
    of_task: dict[str, OutputPort] = {}
    if config.reach is not None:
        target = add_tip_target(builder, parts.fingers[0], (config.reach.pressure[0], config.reach.pressure[1]))
        of_task["target"] = target.get_output_port()
    if config.pick_place is not None:
        goal = builder.AddNamedSystem("goal", ConstantVectorSource([config.pick_place.goal[0]]))
        of_task["goal"] = describe(goal.get_output_port(), "m")
    observation = add_observation(builder, config.observation, parts.signals | of_task)
    builder.ExportOutput(observation, "observation")
    if picture:
        builder.ExportOutput(add_camera(builder, parts), "picture")
    diagram = builder.Build()
    parts.check(diagram)
    handled, seen = config.grasp or config.pick_place, picture or meshcat is not None
    if handled is None:
        return LearningStation(diagram, parts, forces, seen, target=target)
    body = first_body(parts.plant, handled.object)
    return LearningStation(diagram, parts, forces, seen, body, _height(parts, body), goal=goal)


def _add_action(builder: DiagramBuilder, config: EnvironmentConfig, parts: StationParts) -> None:
    inputs = dict(parts.inputs)
    desired = None if parts.arm is None else inputs.pop(f"{parts.arm.name}.desired_state", None)
    add_action(builder, config.action, [*inputs.values()], desired, home(parts), parts.plant.time_step())


def home(parts: StationParts) -> dict[str, float]:
    """Positions in which the joints of the arm begin, by their names; none without an arm."""
    if parts.arm is None:
        return {}
    names = [joint.name() for joint in arm_joints(parts.plant, parts.arm.model)]
    return dict(zip(names, map(float, parts.arm.home), strict=True))


def _height(parts: StationParts, body: RigidBody) -> float:
    """Of the frame of a body over its lowest point where it begins, m."""
    plant, context = parts.plant, parts.plant.CreateDefaultContext()
    corners = box_corners(plant, parts.scene_graph, context, [body.model_instance()], Role.kProximity)
    return float(body.EvalPoseInWorld(context).translation()[2] - corners[:, 2].min())
