"""SceneRenderer: a recording at any time -> a picture of its scene, without a display or a simulation."""

from itertools import product

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from pydrake.geometry import GeometryId, PerceptionProperties, QueryObject, Rgba, Role
from pydrake.multibody.tree import ModelInstanceIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.plant import PlantFinger, add_plant
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.diagrams.torque_colors import color
from soft_gripper.finger_links import link_name
from soft_gripper.pictures.camera import framing_camera
from soft_gripper.pictures.meshes import give_normals
from soft_gripper.pictures.studio import make_studio

Picture = NDArray[np.uint8]  # (height, width, 3) red, green, blue

_RENDERER = "vtk"
_OVERSAMPLING = 2  # rendered so much larger and then reduced, against jagged edges
_FRAMED_STATES = 30  # of a recording, that the camera is chosen for


class SceneRenderer:
    """Looks at what was recorded of a scenario with one camera that sees all of the motion.

    If `torque_limit` is given, N m, the links of the fingers have the colours of the true external torque
    on a scale that ends there, and otherwise the colours of the model.
    """

    def __init__(
        self,
        scenario: Scenario,
        recording: Recording,
        height: int = 900,
        width: int | None = None,
        torque_limit: float | None = None,
    ):
        builder = DiagramBuilder()
        self._plant, self._scene_graph, self._fingers = add_plant(builder, scenario)
        give_normals(self._scene_graph, self._plant.get_source_id())
        self._scene_graph.AddRenderer(_RENDERER, make_studio())
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._recording, self._torque_limit = recording, torque_limit
        states = recording["plant.state"].values
        shown = states[np.linspace(0, len(states) - 1, _FRAMED_STATES).astype(int)]
        self.camera = framing_camera(np.concatenate([self._corners(state) for state in shown]), height, width)

    def render(self, time: float) -> Picture:
        """The scene at a time of the recording, s."""
        now = self._recording.data.sel(time=time, method="nearest")
        if self._torque_limit is not None:
            for finger in self._fingers:
                torque = now[f"{finger.name}.true_external_torque"].values
                self._paint(finger, color(torque, self._torque_limit))
        camera, world = self.camera.render_camera(_RENDERER, _OVERSAMPLING), self._scene_graph.world_frame_id()
        image = self._query(now["plant.state"].values).RenderColorImage(camera, world, self.camera.X_WC).data
        size = (self.camera.width, self.camera.height)
        return np.asarray(Image.fromarray(image[..., :3]).resize(size, Image.Resampling.BOX))

    def _paint(self, finger: PlantFinger, joint_colors: Array) -> None:
        """Gives each link the colour of the joint at which it begins; the first link shares the second's."""
        for link, rgb in enumerate([joint_colors[0], *joint_colors]):
            body = self._plant.GetBodyByName(link_name(finger.name, link), finger.model)
            self._paint_body(body, Rgba(*rgb))

    def _paint_body(self, body: RigidBody, rgba: Rgba) -> None:
        inspector, source = self._scene_graph.model_inspector(), self._plant.get_source_id()
        context = self._scene_graph.GetMyMutableContextFromRoot(self._context)
        for geometry in self._geometries(body):
            properties = PerceptionProperties(inspector.GetPerceptionProperties(geometry))
            properties.UpdateProperty("phong", "diffuse", rgba)
            # Drake does not replace the properties of this role.
            self._scene_graph.RemoveRole(context, source, geometry, Role.kPerception)
            self._scene_graph.AssignRole(context, source, geometry, properties)

    def _query(self, state: Array) -> QueryObject:
        plant_context = self._plant.GetMyMutableContextFromRoot(self._context)
        self._plant.SetPositionsAndVelocities(plant_context, state)
        port = self._scene_graph.get_query_output_port()
        return port.Eval(self._scene_graph.GetMyContextFromRoot(self._context))

    def _corners(self, state: Array) -> Array:
        """Corners of the boxes around all parts of the models that can move, (M, 3) m in the world."""
        query, plant = self._query(state), self._plant
        models = map(ModelInstanceIndex, range(plant.num_model_instances()))
        bodies = [
            plant.get_body(index)
            for model in models
            if plant.num_positions(model) > 0
            for index in plant.GetBodyIndices(model)
        ]
        boxes = [query.ComputeObbInWorld(geometry) for body in bodies for geometry in self._geometries(body)]
        signs = np.array(list(product((-1, 1), repeat=3)))
        return np.concatenate([b.pose() @ (signs * b.half_width()).T for b in boxes], axis=1).T

    def _geometries(self, body: RigidBody) -> list[GeometryId]:
        frame = self._plant.GetBodyFrameIdOrThrow(body.index())
        return self._scene_graph.model_inspector().GetGeometries(frame, Role.kPerception)
