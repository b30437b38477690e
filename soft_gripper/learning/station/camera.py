"""What a learning environment shows: a picture of the scene, or Meshcat."""

import numpy as np
from pydrake.geometry import DepthRange, DepthRenderCamera, Role
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.sensors import RgbdSensor

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import StationParts
from soft_gripper.diagrams.view.viewpoint import box_corners
from soft_gripper.pictures.camera import DIRECTION, framing_camera
from soft_gripper.pictures.rendering import make_studio

HEIGHT, WIDTH = 360, 480  # pixels of a picture
_RENDERER = "learning"
_LIFTED = np.array([0.0, 0.0, 0.1])  # m, by which what moves may rise


def add_camera(builder: DiagramBuilder, station: StationParts) -> OutputPort:
    """Adds `camera`, which sees the fingers and what they handle; returns its picture."""
    station.scene_graph.AddRenderer(_RENDERER, make_studio())
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
