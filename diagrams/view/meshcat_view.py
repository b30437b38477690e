"""The scene in Meshcat: the bodies, the estimates drawn over them, a legend and a camera.

A Meshcat accepts commands and junk from anyone who can connect: it checks neither Host nor Origin, and one message
that is not MessagePack ends its thread. Every later call then raises a RuntimeError, and its destructor waits until the
last client has disconnected.
"""

import gzip
import logging
import secrets
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from ipaddress import IPv4Address
from itertools import product
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatParams, MeshcatVisualizer, MeshcatVisualizerParams, Rgba, Role, SceneGraph
from pydrake.lcm import DrakeLcmParams
from pydrake.math import RotationMatrix
from pydrake.multibody.meshcat import ContactVisualizer, ContactVisualizerParams
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort
from pydrake.systems.lcm import ApplyLcmBusConfig
from pydrake.visualization import ApplyVisualizationConfig, VisualizationConfig

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import Scene
from soft_gripper.diagrams.view.estimate_visualizer import DrawnFinger, EstimateVisualizer
from soft_gripper.diagrams.view.finger_drawing import LENGTH, MIN_FORCE, drawn_signals
from soft_gripper.diagrams.view.torque_colors import draw_torque_legend, round_limit
from soft_gripper.diagrams.wiring.named_wires import inputs
from soft_gripper.errors import InputError
from soft_gripper.estimators.finger_shape import ARC
from soft_gripper.files.output import atomic_file
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.deformables import deformable_kind
from soft_gripper.scenario.schema import ArmConfig, ModelConfig, PressureConfig, Scenario, TaskConfig

LOOPBACK = "127.0.0.1"


def hidden_meshcat() -> Meshcat:
    """A Meshcat at an unpredictable place: a random loopback address and a random port.

    A web page cannot guess both, out of some 2^38. If the loopback has a single address, as on macOS, only the port is
    random. Drake no longer says where it is.

    Raises:
        InputError: if none is free.
    """
    logging.getLogger("drake").setLevel(logging.WARNING)  # suppress the "Meshcat listening" messages
    address = IPv4Address("127.0.0.2") + secrets.randbelow(2**24 - 4)
    for host in (str(address), LOOPBACK):
        with suppress(RuntimeError):
            return Meshcat(MeshcatParams(host=host, port=0, show_stats_plot=False))
    raise InputError("Meshcat", "port", "any", f"no free port at {LOOPBACK}")


_CAMERA_TURN = np.radians(45.0)  # to the right, so that the arm is behind the gripper and does not hide it
_CAMERA_DESCENT = 0.35  # per metre forward, so that the height above the bench is visible
_BOX_CORNERS = np.array(list(product((-1, 1), repeat=3)))  # of a box, in half widths


def viewing_direction(
    arm: ArmConfig | None, plant: MultibodyPlant, fingers: Sequence[PlantFinger], without_arm: Array
) -> Array:
    """The viewing direction into a scene, (3) in the world, of any length.

    An arm is viewed from the front, from one side and from above; the front is where its initial posture holds the
    fingers. `without_arm` is the direction for fingers without an arm.
    """
    if arm is None:
        return without_arm
    foot = plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(arm.model))[0])
    p_WFoot = plant.EvalBodyPoseInWorld(plant.CreateDefaultContext(), foot).translation()
    view_vector = np.mean([finger.X_WB.translation() for finger in fingers], axis=0) - p_WFoot
    turn = RotationMatrix.MakeZRotation(np.arctan2(view_vector[1], view_vector[0]) + _CAMERA_TURN)
    return turn @ np.array([0.0, 1.0, -_CAMERA_DESCENT])


def upright_view(direction: Array) -> RotationMatrix:
    """The camera axes of an upright picture, in the world: x to the right, y down and z along `direction`."""
    z = direction / np.linalg.norm(direction)
    x = np.cross(z, [0.0, 0.0, 1.0]) / np.hypot(z[0], z[1])
    return RotationMatrix(np.column_stack([x, np.cross(z, x), z]))


def nearest_eye(p_W: Array, R_WC: RotationMatrix, min_slopes: Array, max_slopes: Array) -> Array:
    """The nearest camera position, (3) m, from which all points, (M, 3) m, lie within the picture.

    The axes of the picture are R_WC. In these axes, a camera at c sees a point p if the components of p - c
    to the right and down are between `min_slopes`, (2), and `max_slopes`, (2), times the distance p_z - c_z.
    """
    coordinates = p_W @ R_WC.matrix()
    lowest = np.max(coordinates[:, :2] - max_slopes * coordinates[:, 2:], axis=0)
    highest = np.min(coordinates[:, :2] - min_slopes * coordinates[:, 2:], axis=0)
    depth = np.min((highest - lowest) / (max_slopes - min_slopes))
    return R_WC.matrix() @ [*(lowest + highest + (min_slopes + max_slopes) * depth) / 2, depth]


def box_corners(
    plant: MultibodyPlant, scene_graph: SceneGraph, context: Context, models: Iterable[ModelInstanceIndex], role: Role
) -> Array:
    """Corners of the bounding boxes of all geometries with a role in some models, (M, 3) m in the world.

    `context` is the plant's.
    """
    inspector = scene_graph.model_inspector()
    corners = []
    for body in (plant.get_body(index) for model in models for index in plant.GetBodyIndices(model)):
        X_WBody = plant.EvalBodyPoseInWorld(context, body)
        for geometry in inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()), role):
            box = inspector.GetObbInGeometryFrame(geometry)
            X_WBox = X_WBody @ inspector.GetPoseInFrame(geometry) @ box.pose()
            corners.append((X_WBox @ (_BOX_CORNERS * box.half_width()).T).T)
    return np.concatenate([np.empty((0, 3)), *corners])


PERIOD = 1 / 20  # s between frames
FIELD_OF_VIEW = np.radians(35)  # vertical
_MIN_ASPECT = 1.5  # smallest width over height of a window that still shows everything
_ARROW_COLOR = Rgba(0.45, 0.1, 0.5)
_DEFAULT_DIRECTION = np.array([-0.25, 1.0, -0.25])  # viewing direction for fingers without an arm
_CAMERA_MARGIN = 1.1
_FILL_LIGHT = np.array([-4.0, -3.0, -10.0])  # its position: right, down and ahead of the camera, m
_FILL_INTENSITY = 1.4
_LEGEND_FRACTION = 0.15  # of the height of the view, left free for the legend
# Corners, in B, of the region that a finger and its mount can reach, in finger lengths.
_REACH_CORNERS = np.array([[x, 0, z] for x in (-0.5, 0.5) for z in (-0.3, 1.0)])


def add_meshcat_view(
    builder: DiagramBuilder,
    scene: Scene,
    signals: Mapping[str, OutputPort],
    meshcat: Meshcat,
    scenario: Scenario,
) -> None:
    """Adds the visualizers of bodies, true contact forces and estimates, and sets up camera, light and legend.

    The whole workspace of the scenario is kept in view, and its pressures determine the torque scale. `signals`: see
    `add_estimates`.
    """
    visualization = scenario.visualization
    add_estimates(builder, scene, signals, meshcat, scenario.pressure)
    kind = deformable_kind()
    if kind is not None and scene.deformables:
        kind.add_view(builder, scene.plant, scene.scene_graph, scene.deformables, signals, meshcat, PERIOD)
    if visualization is None or visualization.publish_contacts:
        ContactVisualizer.AddToBuilder(builder, scene.plant, meshcat, _contact_arrows())
    if visualization is not None:
        _add_others(builder, scene, meshcat, visualization)
    set_up_view(scene, meshcat, scenario)


def _add_others(builder: DiagramBuilder, scene: Scene, meshcat: Meshcat, config: VisualizationConfig) -> None:
    """Adds the further visualizers of Drake's config, without bodies and contacts, which are drawn already."""
    other_config = deepcopy(config)
    other_config.publish_illustration = other_config.publish_contacts = False
    # Drake also publishes its shapes as LCM messages, which nothing receives; the diagram owns where they go.
    lcm_config = ApplyLcmBusConfig({other_config.lcm_bus: DrakeLcmParams(lcm_url="memq://")}, builder)
    ApplyVisualizationConfig(other_config, builder, lcm_config, scene.plant, scene.scene_graph, meshcat)


def add_estimates(
    builder: DiagramBuilder,
    scene: Scene,
    signals: Mapping[str, OutputPort],
    meshcat: Meshcat,
    pressure: PressureConfig,
) -> None:
    """Adds the visualizers of bodies and of estimates.

    `signals` must contain `{finger}.arcs`, `{finger}.external_torque`, joints and tip; contact and `position_std` are
    drawn if present, see EstimateVisualizer. For the other arguments see `add_meshcat_view`.
    """
    plant, scene_graph, fingers, *_ = scene
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=PERIOD))
    drawn_fingers = [_drawn_finger(scene_graph, finger, signals) for finger in fingers]
    limit = torque_limit(pressure, fingers)
    # After the visualizer of the bodies, whose colours it sets.
    estimates = builder.AddNamedSystem("estimate_visualizer", EstimateVisualizer(meshcat, drawn_fingers, limit, PERIOD))
    builder.Connect(plant.get_body_poses_output_port(), estimates.GetInputPort("body_poses"))
    for name, port in inputs(estimates).items():
        if name != "body_poses":
            builder.Connect(signals[name], port)


def set_up_view(scene: Scene, meshcat: Meshcat, scenario: Scenario) -> None:
    """Sets up camera, light and legend for a scene. For the arguments see `add_meshcat_view`."""
    direction = viewing_direction(scenario.arm, scene.plant, scene.fingers, _DEFAULT_DIRECTION)
    _set_scene(meshcat)
    if scenario.arm is not None:
        # A brighter light next to the camera; Meshcat's own lights suit the view of fingers without an arm.
        meshcat.SetProperty("/Lights/FillLight/<object>", "position", [*upright_view(direction) @ _FILL_LIGHT])
        meshcat.SetProperty("/Lights/FillLight/<object>", "intensity", _FILL_INTENSITY)
    _aim_camera(meshcat, _landmarks(scene, scenario.models, scenario.arm, scenario.task), direction)
    draw_torque_legend(meshcat, torque_limit(scenario.pressure, scene.fingers), FIELD_OF_VIEW)


def _contact_arrows() -> ContactVisualizerParams:
    """Draws true contact forces as the estimated ones, without their moments."""
    return ContactVisualizerParams(
        publish_period=PERIOD,
        newtons_per_meter=1 / LENGTH,
        force_threshold=MIN_FORCE,
        moment_threshold=np.inf,
        radius=0.8e-3,
        color=_ARROW_COLOR,
        hydro_force_color=_ARROW_COLOR,
    )


def torque_limit(pressure: PressureConfig, fingers: Sequence[PlantFinger]) -> float:
    """Limit of the colour scale, N m: the largest torque of the pressure supply at a joint, rounded up."""
    largest = max(abs(pressure.minimum), abs(pressure.maximum))
    torques = []
    for finger in (finger.finger for finger in fingers):  # one without chambers by its `pressure_gain`
        chambers = np.full(finger.pressures, largest)
        effective = finger.effective_pressure(chambers).max() if finger.pressures else largest
        torques.append(float(effective * finger.pressure_gain.max()))
    return round_limit(max(torques))


def _drawn_finger(scene_graph: SceneGraph, finger: PlantFinger, signals: Mapping[str, OutputPort]) -> DrawnFinger:
    skin = tuple(geometry_paths(finger.plant, scene_graph, link.index()) for link in finger.links)
    sizes_by_signal = {name.removeprefix(f"{finger.name}."): port.size() for name, port in signals.items()}
    sizes = {name: sizes_by_signal[name] for name in drawn_signals(sizes_by_signal)}
    return DrawnFinger(
        finger.name, finger.finger, sizes_by_signal["arcs"] // len(ARC), finger.base.index(), skin, sizes
    )


def geometry_paths(plant: MultibodyPlant, scene_graph: SceneGraph, body: int) -> tuple[str, ...]:
    """Paths of the geometries of a body in the MeshcatVisualizer."""
    inspector = scene_graph.model_inspector()
    frame = plant.GetBodyFrameIdOrThrow(body)
    geometries = inspector.GetGeometries(frame, Role.kIllustration)
    names = (f"{inspector.GetName(frame)}::{inspector.GetName(geometry)}" for geometry in geometries)
    return tuple(f"/drake/visualizer/{name.replace('::', '/')}" for name in names)


def _set_scene(meshcat: Meshcat) -> None:
    """Sets a plain, light background."""
    meshcat.SetProperty("/Background/<object>", "top_color", [1.0, 1.0, 1.0])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.88, 0.9, 0.92])
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)


def _landmarks(scene: Scene, models: Sequence[ModelConfig], arm: ArmConfig | None, task: TaskConfig | None) -> Array:
    """Points to keep in view, (M, 3) m: the reach of the fingers, the arm, the object handled, and its goal."""
    plant, scene_graph, fingers, deformables, couplings, _ = scene
    points = [finger.X_WB @ (finger.finger.length * corner) for finger in fingers for corner in _REACH_CORNERS]
    if arm is not None and couplings is not None:
        model = plant.GetModelInstanceByName(arm.model)
        context = plant.CreateDefaultContext()
        moving_models = {model, *(finger.model for finger in fingers)}
        for posture in [arm.home, *(phase.posture for phase in (task.phases if task else ()) if phase.posture)]:
            plant.SetPositions(context, model, couplings.full(np.array(posture)))
            points += [*box_corners(plant, scene_graph, context, moving_models, Role.kIllustration)]
    free_models = [plant.GetModelInstanceByName(model.name) for model in models if model.free]
    context = plant.CreateDefaultContext()
    points += [*box_corners(plant, scene_graph, context, free_models, Role.kIllustration)]
    points += [vertex for deformable in deformables.values() for vertex in deformable.vertices(context)]
    if task is not None and task.object is not None:
        points.append(task.X_WGoal.GetDeterministicValue().translation())
    return np.array(points)


def _aim_camera(meshcat: Meshcat, points: Array, direction: Array) -> None:
    """A camera that sees all points, (M, 3) m, above the legend."""
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=np.degrees(FIELD_OF_VIEW)))
    view = upright_view(direction)
    edge = np.tan(FIELD_OF_VIEW / 2) / _CAMERA_MARGIN
    min_slopes, max_slopes = (
        edge * np.array([-_MIN_ASPECT, -1.0]),
        edge * np.array([_MIN_ASPECT, 1.0 - 2 * _LEGEND_FRACTION]),
    )
    eye = nearest_eye(points, view, min_slopes, max_slopes)
    middle = (np.min(points, axis=0) + np.max(points, axis=0)) / 2
    view_axis = view.matrix()[:, 2]
    meshcat.SetCameraPose(eye, eye + ((middle - eye) @ view_axis) * view_axis)


_PAGE_TEMPLATE = """<!DOCTYPE html>
<html><head><meta charset="utf-8"><title>soft-gripper</title></head><body>
<noscript>The animation needs JavaScript.</noscript>
<script>
// Meshcat's own page is kept compressed inside this one, which it replaces.
(async () => {
  const packed = await fetch("data:application/gzip;base64,%s");
  const page = await new Response(packed.body.pipeThrough(new DecompressionStream("gzip"))).text();
  document.open();
  document.write(page);
  document.close();
})();
</script></body></html>
"""


def write_animation(meshcat: Meshcat, path: Path) -> None:
    """Writes the scene and the recorded animation of a Meshcat to a file."""
    packed = gzip.compress(meshcat.StaticHtml().encode(), mtime=0)
    with atomic_file(path) as partial:
        partial.write_text(_PAGE_TEMPLATE % b64encode(packed).decode(), encoding="utf-8")
