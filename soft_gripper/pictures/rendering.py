"""SceneRenderer: a recording at any time -> a picture of its scene, without a display or a simulation."""

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from pydrake.geometry import (
    LightParameter,
    MakeRenderEngineVtk,
    PerceptionProperties,
    RenderEngine,
    RenderEngineVtkParams,
    Rgba,
    Role,
    SsaoParameter,
)
from pydrake.math import RotationMatrix
from pydrake.multibody.tree import BodyIndex

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.view.torque_colors import color
from soft_gripper.diagrams.view.viewpoint import viewing_direction
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.pictures.camera import DIRECTION, Camera, framing_camera
from soft_gripper.pictures.replayed_scene import ReplayedScene
from soft_gripper.scenario.scenario import Scenario

# Position before a viewer who looks along +y, m, and intensity. Lamps at a point cast no shadows.
LAMPS = (
    ((0.0, -1.0, 6.0), 0.8),
    ((-2.0, -6.0, 1.5), 0.6),
    ((6.0, -2.0, 0.5), 0.38),
    ((-6.0, -2.0, 0.5), 0.42),
    ((0.0, -1.0, -6.0), 0.3),
)
DIMMED = 0.9  # what is left of that beside the sun
SUN = np.array([-0.22, -0.40, 0.89])  # direction in which it stands, of length 1
SUN_INTENSITY = 0.25
SUN_DISTANCE = 8.0  # in radii of what it shines on
_CONE = 12.0  # degrees from the middle of its light to the edge
_WHITE = [1.0, 1.0, 1.0]


def make_renderer() -> RenderEngine:
    """A renderer for fingers alone: lamps all round, a white background, and soft shading where things meet."""
    shading = SsaoParameter(radius=0.03, bias=0.01, sample_count=16, blur=True)
    lamps = [_lamp(np.array(position), intensity) for position, intensity in LAMPS]
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=_WHITE, lights=lamps, ssao=shading))


def make_workshop(direction: Array, p_W: Array) -> RenderEngine:
    """A renderer for an arm: lamps round one who looks in `direction`, and a sun, whose shadows show heights.

    The sun shines on what lies between the points p_W, (M, 3) m, and round about.
    """
    turn = RotationMatrix.MakeZRotation(np.arctan2(-direction[0], direction[1]))
    lamps = [_lamp(turn @ np.array(position), DIMMED * intensity) for position, intensity in LAMPS]
    radius, toward_sun = np.linalg.norm(np.ptp(p_W, axis=0)) / 2, turn @ SUN
    sun = LightParameter(
        type="spot",
        frame="world",
        position=(p_W.min(axis=0) + p_W.max(axis=0)) / 2 + SUN_DISTANCE * radius * toward_sun,
        direction=-toward_sun,
        cone_angle=_CONE,
        intensity=SUN_INTENSITY,
    )
    lights, shadows = [*lamps, sun], {"cast_shadows": True, "shadow_map_size": 2048}
    return MakeRenderEngineVtk(RenderEngineVtkParams(default_clear_color=_WHITE, lights=lights, **shadows))


def _lamp(position: Array, intensity: float) -> LightParameter:
    return LightParameter(type="point", frame="world", position=position, intensity=intensity)


Picture = NDArray[np.uint8]  # (height, width, 3) red, green, blue

_RENDERER = "vtk"
_OVERSAMPLING = 2  # rendered so much larger and then reduced, against jagged edges
_FARTHEST = 2.0  # m, from the middle of all, that is framed
_FRAMED_TIMES = 30  # of a recording, that the camera is chosen for


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
        self.scene = scene = ReplayedScene(scenario, recording)
        self._torque_limit = torque_limit
        times = scene.times[np.linspace(0, len(scene.times) - 1, _FRAMED_TIMES).astype(int)]
        corners = np.concatenate([scene.framed_corners(time) for time in times])
        # What has fallen far away would leave nothing else to be seen.
        corners = corners[np.linalg.norm(corners - np.median(corners, axis=0), axis=1) < _FARTHEST]
        self.direction = viewing_direction(scenario.arm, scene.plant, scene.fingers, DIRECTION)
        self.camera = framing_camera(corners, height, width, self.direction)
        engine = make_workshop(self.direction, corners) if scenario.arm is not None else make_renderer()
        scene.scene_graph.AddRenderer(scene.scene_graph_context, _RENDERER, engine)

    def render(self, time: float, camera: Camera | None = None) -> Picture:
        """The scene at a time of the recording, s, as its own camera or another sees it."""
        camera = camera or self.camera
        self._paint_fingers(time)
        query, world = self.scene.query(time), self.scene.scene_graph.world_frame_id()
        image = query.RenderColorImage(camera.render_camera(_RENDERER, _OVERSAMPLING), world, camera.X_WC).data
        size = (camera.width, camera.height)
        return np.asarray(Image.fromarray(image[..., :3]).resize(size, Image.Resampling.BOX))

    def _paint_fingers(self, time: float) -> None:
        if self._torque_limit is not None:
            signals = self.scene.signals(time)
            for finger in self.scene.fingers:
                torque = signals[f"{finger.name}.true_external_torque"].values
                self._paint(finger, color(torque, self._torque_limit))

    def _paint(self, finger: PlantFinger, joint_colors: Array) -> None:
        """Gives each link the colour of the joint at which it begins; the first link shares the second's."""
        for link, rgb in zip(finger.links, [joint_colors[0], *joint_colors], strict=True):
            self._paint_body(link.index(), Rgba(*rgb))

    def _paint_body(self, body: BodyIndex, rgba: Rgba) -> None:
        scene_graph, context = self.scene.scene_graph, self.scene.scene_graph_context
        inspector, source = scene_graph.model_inspector(), self.scene.plant.get_source_id()
        for geometry in self.scene.geometries(body):
            properties = PerceptionProperties(inspector.GetPerceptionProperties(geometry))
            properties.UpdateProperty("phong", "diffuse", rgba)
            # Drake does not replace the properties of this role.
            scene_graph.RemoveRole(context, source, geometry, Role.kPerception)
            scene_graph.AssignRole(context, source, geometry, properties)
