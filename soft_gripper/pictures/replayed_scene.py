"""ReplayedScene: the models of a scenario where they were at any time of a recording, without a simulation."""

from collections.abc import Iterable

import numpy as np
import trimesh
import xarray as xr
from pydrake.common import MemoryFile
from pydrake.geometry import GeometryId, InMemoryMesh, Mesh, QueryObject, Role, SceneGraph, SourceId
from pydrake.multibody.tree import BodyIndex, ModelInstanceIndex
from pydrake.systems.framework import Context, DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.view.viewpoint import box_corners
from soft_gripper.scenario.scenario import Scenario


def give_normals(scene_graph: SceneGraph, source: SourceId) -> None:
    """Puts meshes with normals in the place of OBJ files without, wherever a renderer would see one."""
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        shape = inspector.GetShape(geometry)
        if isinstance(shape, Mesh) and shape.extension() == ".obj" and shape.source().is_path():
            text = shape.source().path().read_text(encoding="utf-8")
            if "\nvn " not in text:
                scene_graph.ChangeShape(source, geometry, _with_normals(shape))


def _with_normals(mesh: Mesh) -> Mesh:
    """The same mesh, shaded smoothly but for its sharp edges."""
    smooth = trimesh.load(mesh.source().path(), force="mesh").smooth_shaded
    text = trimesh.exchange.obj.export_obj(smooth, include_normals=True, include_texture=False, header=None)
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "mesh with normals")), mesh.scale3())


class ReplayedScene:
    """Plant and SceneGraph of a scenario, their context, and the recording whose states they take."""

    def __init__(self, scenario: Scenario, recording: Recording):
        builder = DiagramBuilder()
        scene = add_plant(builder, scenario.plant_config, scenario.models, scenario.gravity, scenario.arm)
        self.plant, self.scene_graph, self.fingers = scene
        give_normals(self.scene_graph, self.plant.get_source_id())
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._recording = recording

    @property
    def times(self) -> Array:
        """Of the recorded samples, s."""
        times: Array = self._recording.data["time"].values
        return times

    @property
    def scene_graph_context(self) -> Context:
        """Of the SceneGraph; what is changed in it lasts."""
        return self.scene_graph.GetMyMutableContextFromRoot(self._context)

    def signals(self, time: float) -> xr.Dataset:
        """All that was recorded at the sample nearest to a time, s."""
        return self._recording.data.sel(time=time, method="nearest")

    def query(self, time: float) -> QueryObject:
        """The geometries where they are at a time, s."""
        self._go_to(time)
        return self.scene_graph.get_query_output_port().Eval(self.scene_graph_context)

    def model_position(self, name: str, time: float) -> Array:
        """Where the first link of a model is at a time, s; (3) m in the world."""
        return self._position(self.plant.GetBodyIndices(self.plant.GetModelInstanceByName(name))[0], time)

    def gripper_position(self, time: float) -> Array:
        """The middle between the bases of the fingers at a time, s; (3) m in the world."""
        middle: Array = np.mean([self._position(finger.base.index(), time) for finger in self.fingers], axis=0)
        return middle

    def gripper_corners(self, time: float) -> Array:
        """Corners of the boxes around all parts of the models with fingers at a time, s; (M, 3) m in the world."""
        return self._corners({finger.model for finger in self.fingers}, time)

    def framed_corners(self, time: float) -> Array:
        """Corners of the boxes around what a picture must show at a time, s; (M, 3) m in the world.

        That is all that can move, and what is fixed and smaller, such as a peg, but no table.
        """
        models = [ModelInstanceIndex(index) for index in range(self.plant.num_model_instances())]
        moving = self._corners((model for model in models if self.plant.num_positions(model) > 0), time)
        fixed = [self._corners([model], time) for model in models if self.plant.num_positions(model) == 0]
        small = [corners for corners in fixed if len(corners) and _extent(corners) < _extent(moving) / 2]
        return np.concatenate([moving, *small])

    def geometries(self, body: BodyIndex) -> list[GeometryId]:
        """What is seen of a body."""
        frame = self.plant.GetBodyFrameIdOrThrow(body)
        return self.scene_graph.model_inspector().GetGeometries(frame, Role.kPerception)

    def _position(self, body: BodyIndex, time: float) -> Array:
        position: Array = self.plant.EvalBodyPoseInWorld(self._go_to(time), self.plant.get_body(body)).translation()
        return position

    def _corners(self, models: Iterable[ModelInstanceIndex], time: float) -> Array:
        return box_corners(self.plant, self.scene_graph, self._go_to(time), models, Role.kPerception)

    def _go_to(self, time: float) -> Context:
        """The context of the plant, in the state of a time."""
        context = self.plant.GetMyMutableContextFromRoot(self._context)
        self.plant.SetPositionsAndVelocities(context, self.signals(time)["plant.state"].values)
        return context


def _extent(corners: Array) -> float:
    """The diagonal of the box around points, m."""
    return float(np.linalg.norm(np.ptp(corners, axis=0)))
