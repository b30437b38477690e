"""make_learning_station: an environment -> a diagram with the ports `action` and `observation`, built once."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import DepthRange, DepthRenderCamera, Meshcat, Role
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantVectorSource
from pydrake.systems.sensors import RgbdSensor

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import arm_joints, first_body
from soft_gripper.diagrams.station import add_station
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.diagrams.view.viewpoint import box_corners
from soft_gripper.learning.schema.config import EnvironmentConfig
from soft_gripper.learning.station.actions import add_action
from soft_gripper.learning.station.observation import add_observation
from soft_gripper.learning.station.peak_force import PeakForce, add_peak_force
from soft_gripper.learning.station.tip_target import TipTarget, add_tip_target
from soft_gripper.pictures.camera import DIRECTION, framing_camera
from soft_gripper.pictures.rendering import make_renderer
from soft_gripper.scenario.scenario import Scenario
from soft_gripper.signals import describe

HEIGHT, WIDTH = 360, 480  # pixels of a picture
_RENDERER = "learning"
_LIFTED = np.array([0.0, 0.0, 0.1])  # m, by which what moves may rise


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
        builder.ExportOutput(_add_camera(builder, parts), "picture")
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


def _add_camera(builder: DiagramBuilder, station: StationParts) -> OutputPort:
    """Adds `camera`, which sees the fingers and what they handle; returns its picture."""
    station.scene_graph.AddRenderer(_RENDERER, make_renderer())
    camera = framing_camera(_seen(station), HEIGHT, WIDTH, DIRECTION)
    color = camera.render_camera(_RENDERER, 1)
    depth = DepthRenderCamera(color.core(), DepthRange(0.05, 5.0))  # RgbdSensor wants one, which nothing asks for
    sensor = RgbdSensor(station.scene_graph.world_frame_id(), camera.X_WC, color, depth)
    builder.AddNamedSystem("camera", sensor)
    builder.Connect(station.scene_graph.get_query_output_port(), sensor.query_object_input_port())
    return sensor.color_image_output_port()


def _seen(station: StationParts) -> Array:
    """Corners of what is to be in the picture, (M, 3) m: fingers and free objects, where they begin and lifted."""
    plant, context = station.plant, station.plant.CreateDefaultContext()
    models = {finger.model for finger in station.fingers}
    models |= {plant.GetModelInstanceByName(model.name) for model in station.scenario.models if model.free}
    corners = box_corners(plant, station.scene_graph, context, models, Role.kPerception)
    return np.concatenate([corners, corners + _LIFTED])
