"""SceneRenderer: renders a recorded scene at any time, without a display or a simulation."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import trimesh
import xarray as xr
from numpy.typing import NDArray
from PIL import Image
from pydrake.common import MemoryFile
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    GeometryId,
    InMemoryMesh,
    LightParameter,
    MakeRenderEngineVtk,
    Mesh,
    PerceptionProperties,
    QueryObject,
    RenderCameraCore,
    RenderEngine,
    RenderEngineVtkParams,
    Rgba,
    Role,
    SceneGraph,
    SourceId,
    SsaoParameter,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import BodyIndex, ModelInstanceIndex
from pydrake.systems.framework import Context, DiagramBuilder
from pydrake.systems.sensors import CameraInfo

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import add_plant
from soft_gripper.diagrams.view.meshcat_view import box_corners, nearest_eye, upright_view, viewing_direction
from soft_gripper.diagrams.view.torque_colors import link_colors
from soft_gripper.files.text import read_bytes
from soft_gripper.scenario.schema import Scenario

ANGLE_OF_VIEW = np.radians(20.0)  # vertical
DIRECTION = np.array([0.2, 1.0, -0.22])  # for fingers without an arm: onto the x-z plane, from slightly left and above
MARGIN = 0.08  # share of the picture left free around its contents
ASPECTS = (0.9, 2.0)  # narrowest and widest, if no width is given
# Position, m, for a viewer who looks along +y, and intensity. Point lights cast no shadows.
LAMPS = (
    ((0.0, -1.0, 6.0), 0.8),
    ((-2.0, -6.0, 1.5), 0.6),
    ((6.0, -2.0, 0.5), 0.38),
    ((-6.0, -2.0, 0.5), 0.42),
    ((0.0, -1.0, -6.0), 0.3),
)
DIMMED = 0.9  # factor on these intensities when there is a sun
SUN = np.array([-0.22, -0.40, 0.89])  # unit vector toward it
SUN_INTENSITY = 0.25
SUN_DISTANCE = 8.0  # in radii of the lit region
_SUN_CONE_ANGLE = 12.0  # degrees, half angle of its light cone
_WHITE_COLOR = [1.0, 1.0, 1.0]
_NO_ROTATION, _QUARTER_TURN = RotationMatrix(), RotationMatrix.MakeZRotation(np.pi / 2)
Picture = NDArray[np.uint8]  # (height, width, 3) red, green, blue
_RENDERER_NAME = "vtk"
_OVERSAMPLING = 2  # factor by which pictures are rendered larger and then reduced, against jagged edges
_FARTHEST_FRAMED = 2.0  # m from the centre; anything beyond is not framed
_FRAMED_TIMES = 30  # number of times in a recording that the camera must cover


def give_normals(scene_graph: SceneGraph, source: SourceId) -> None:
    """Replaces OBJ files without normals by meshes with normals, wherever a renderer would see one."""
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        shape = inspector.GetShape(geometry)
        is_file = isinstance(shape, Mesh) and shape.extension() == ".obj" and shape.source().is_path()
        if is_file and b"\nvn " not in read_bytes(shape.source().path()):
            mesh = trimesh.load(shape.source().path(), force="mesh").smooth_shaded  # except at sharp edges
            text = trimesh.exchange.obj.export_obj(mesh, include_normals=True, include_texture=False, header=None)
            memory = InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "mesh with normals"))
            scene_graph.ChangeShape(source, geometry, Mesh(memory, shape.scale3()))


class RecordedScene:
    """Plant and SceneGraph of a scenario, with a context that is set to recorded states."""

    def __init__(self, scenario: Scenario, recording: Recording):
        builder = DiagramBuilder()
        scene = add_plant(builder, scenario)
        self.plant, self.scene_graph, self.fingers, self._deformables, *_ = scene
        give_normals(self.scene_graph, self.plant.get_source_id())
        self._diagram = builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._recording = recording

    @property
    def times(self) -> Array:
        return self._recording.data["time"].values

    @property
    def scene_graph_context(self) -> Context:
        return self.scene_graph.GetMyMutableContextFromRoot(self._context)

    def signals(self, time: float) -> xr.Dataset:
        """The recording at the sample nearest to a time, s."""
        return self._recording.data.sel(time=time, method="nearest")

    def query(self, time: float) -> QueryObject:
        self._go_to(time)
        return self.scene_graph.get_query_output_port().Eval(self.scene_graph_context)

    def object_position(self, name: str, time: float) -> Array:
        """Position of a free model at a time, s; (3) m in the world: its first link's, or its middle if it has none."""
        if name in self._deformables:
            return self._deformables[name].vertices(self._go_to(time)).mean(axis=0)
        return self._position(self.plant.GetBodyIndices(self.plant.GetModelInstanceByName(name))[0], time)

    def gripper_position(self, time: float) -> Array:
        """Mean position of the finger bases at a time, s; (3) m in the world."""
        return np.mean([self._position(finger.base.index(), time) for finger in self.fingers], axis=0)

    def gripper_corners(self, time: float) -> Array:
        """Corners of the bounding boxes of all parts of the models with fingers at a time, s; (M, 3) m in the world."""
        return self._corners({finger.model for finger in self.fingers}, time)

    def framed_corners(self, time: float) -> Array:
        """Corners of the bounding boxes of all that a picture must show at a time, s; (M, 3) m in the world.

        These are all movable bodies, and smaller fixed ones such as a peg, but not a table.
        """
        models = [ModelInstanceIndex(index) for index in range(self.plant.num_model_instances())]
        movable = self._corners((model for model in models if self.plant.num_positions(model) > 0), time)
        fixed_corners = [self._corners([model], time) for model in models if self.plant.num_positions(model) == 0]
        small = [corners for corners in fixed_corners if len(corners) and _extent(corners) < _extent(movable) / 2]
        deformed = [deformable.vertices(self._go_to(time)) for deformable in self._deformables.values()]
        return np.concatenate([movable, *small, *deformed])

    def geometries(self, body: BodyIndex) -> list[GeometryId]:
        frame = self.plant.GetBodyFrameIdOrThrow(body)
        return self.scene_graph.model_inspector().GetGeometries(frame, Role.kPerception)

    def _position(self, body: BodyIndex, time: float) -> Array:
        return self.plant.EvalBodyPoseInWorld(self._go_to(time), self.plant.get_body(body)).translation()

    def _corners(self, models: Iterable[ModelInstanceIndex], time: float) -> Array:
        return box_corners(self.plant, self.scene_graph, self._go_to(time), models, Role.kPerception)

    def _go_to(self, time: float) -> Context:
        """The context of the plant, set to the state at a time."""
        context = self.plant.GetMyMutableContextFromRoot(self._context)
        signals = self.signals(time)
        self.plant.SetPositionsAndVelocities(context, signals["plant.state"].values)
        for deformable in self._deformables.values():
            deformable.restore(context, signals)
        return context


def _extent(corners: Array) -> float:
    """The diagonal of the bounding box of points, m."""
    return float(np.linalg.norm(np.ptp(corners, axis=0)))


@dataclass(frozen=True)
class Camera:
    """A pinhole camera; its frame C has x to the right, y down and z into the picture."""

    X_WC: RigidTransform
    width: int  # pixels
    height: int

    def info(self, scale: int = 1) -> CameraInfo:
        """Drake's intrinsics of the same view with `scale` times as many pixels in a row."""
        return CameraInfo(scale * self.width, scale * self.height, ANGLE_OF_VIEW)

    def render_camera(self, renderer: str, scale: int) -> ColorRenderCamera:
        """The camera in the form that a renderer needs, `scale` times as large."""
        core = RenderCameraCore(renderer, self.info(scale), ClippingRange(0.05, 10.0), RigidTransform())
        return ColorRenderCamera(core)

    def project(self, p_W: Array) -> Array:
        """Projects points in the world, (..., 3) m, onto the picture, (..., 2) pixels right and down."""
        X_CW = self.X_WC.inverse()
        p_C = p_W @ X_CW.rotation().matrix().T + X_CW.translation()
        return (p_C / p_C[..., 2:] @ self.info().intrinsic_matrix().T)[..., :2]


def framing_camera(p_W: Array, height: int, width: int | None = None, direction: Array = DIRECTION) -> Camera:
    """The nearest upright camera that sees all points, (M, 3) m; without `width`, the picture is as wide as they are.

    It looks in `direction`, (3) in the world, of any length.
    """
    R_WC = upright_view(direction)
    if width is None:
        picture_width, picture_height, _ = np.ptp(p_W @ R_WC.matrix(), axis=0)
        width = round(height * np.clip(picture_width / picture_height, *ASPECTS))
    slope = np.tan(ANGLE_OF_VIEW / 2) * (1 - MARGIN) * np.array([width / height, 1.0])
    return Camera(RigidTransform(R_WC, nearest_eye(p_W, R_WC, -slope, slope)), width, height)


def make_renderer(turn: RotationMatrix = _NO_ROTATION, light: float = 1.0) -> RenderEngine:
    """A renderer for fingers without an arm: lights on all sides, a white background, and ambient occlusion.

    The lights turn with the viewer; `light` is a factor on their intensities.
    """
    shading = SsaoParameter(radius=0.03, bias=0.01, sample_count=16, blur=True)
    lamps = [_lamp(turn @ np.array(position), light * intensity) for position, intensity in LAMPS]
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=_WHITE_COLOR, lights=lamps, ssao=shading))


def make_workshop(direction: Array, p_W: Array) -> RenderEngine:
    """A renderer for an arm: lights around a viewer who looks in `direction`, and a sun with shadows that show heights.

    The sun lights the region around the points p_W, (M, 3) m.
    """
    turn = RotationMatrix.MakeZRotation(np.arctan2(-direction[0], direction[1]))
    lamps = [_lamp(turn @ np.array(position), DIMMED * intensity) for position, intensity in LAMPS]
    radius, toward_sun = np.linalg.norm(np.ptp(p_W, axis=0)) / 2, turn @ SUN
    sun = LightParameter(
        type="spot",
        frame="world",
        position=(p_W.min(axis=0) + p_W.max(axis=0)) / 2 + SUN_DISTANCE * radius * toward_sun,
        direction=-toward_sun,
        cone_angle=_SUN_CONE_ANGLE,
        intensity=SUN_INTENSITY,
    )
    lights, shadows = [*lamps, sun], {"cast_shadows": True, "shadow_map_size": 2048}
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=_WHITE_COLOR, lights=lights, **shadows))


def _lamp(position: Array, intensity: float) -> LightParameter:
    return LightParameter(type="point", frame="world", position=position, intensity=intensity)


class SceneRenderer:
    """Renders a recording of a scenario with one camera that covers the whole motion.

    If `torque_limit`, N m, is given, the links of the fingers are coloured by the true external torque on a
    scale that ends there; otherwise, they have the colours of the model. With `aside` the viewer stands farther round
    to the right, by a quarter turn, with the lights. `light` is a factor on the lights of a scene without an arm.
    """

    def __init__(
        self,
        scenario: Scenario,
        recording: Recording,
        height: int = 900,
        width: int | None = None,
        torque_limit: float | None = None,
        aside: bool = False,
        light: float = 1.0,
    ):
        self.scene = scene = RecordedScene(scenario, recording)
        self._torque_limit = torque_limit
        times = scene.times[np.linspace(0, len(scene.times) - 1, _FRAMED_TIMES).astype(int)]
        corners = np.concatenate([scene.framed_corners(time) for time in times])
        # Framing an object that has fallen far away would make everything else too small.
        corners = corners[np.linalg.norm(corners - np.median(corners, axis=0), axis=1) < _FARTHEST_FRAMED]
        turn = _QUARTER_TURN if aside else _NO_ROTATION
        self.direction = turn @ viewing_direction(scenario.arm, scene.plant, scene.fingers, DIRECTION)
        self.camera = framing_camera(corners, height, width, self.direction)
        engine = make_workshop(self.direction, corners) if scenario.arm is not None else make_renderer(turn, light)
        scene.scene_graph.AddRenderer(scene.scene_graph_context, _RENDERER_NAME, engine)

    def render(self, time: float, camera: Camera | None = None) -> Picture:
        """The scene at a time of the recording, s, seen by the default camera or by another one."""
        camera = camera or self.camera
        if self._torque_limit is not None:
            signals = self.scene.signals(time)
            for finger in self.scene.fingers:
                torque = signals[f"{finger.name}.true_external_torque"].values
                for link, rgb in zip(finger.links, link_colors(torque, self._torque_limit), strict=True):
                    self._paint_body(link.index(), Rgba(*rgb))
        query, world = self.scene.query(time), self.scene.scene_graph.world_frame_id()
        image = query.RenderColorImage(camera.render_camera(_RENDERER_NAME, _OVERSAMPLING), world, camera.X_WC).data
        size = (camera.width, camera.height)
        return np.asarray(Image.fromarray(image[..., :3]).resize(size, Image.Resampling.BOX))

    def _paint_body(self, body: BodyIndex, rgba: Rgba) -> None:
        scene_graph, context = self.scene.scene_graph, self.scene.scene_graph_context
        inspector, source = scene_graph.model_inspector(), self.scene.plant.get_source_id()
        for geometry in self.scene.geometries(body):
            properties = PerceptionProperties(inspector.GetPerceptionProperties(geometry))
            properties.UpdateProperty("phong", "diffuse", rgba)
            # Drake does not replace the properties of this role.
            scene_graph.RemoveRole(context, source, geometry, Role.kPerception)
            scene_graph.AssignRole(context, source, geometry, properties)
