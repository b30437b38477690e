"""What a user sees in Meshcat: the bodies, the estimates drawn over them, a legend and a camera."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, Rgba, Role, SceneGraph
from pydrake.multibody.meshcat import ContactVisualizer, ContactVisualizerParams
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper.arrays import Array
from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.diagrams.sensing import sensor_layout
from soft_gripper.diagrams.view.estimate_visualizer import DrawnFinger, EstimateVisualizer
from soft_gripper.diagrams.view.torque_colors import round_limit
from soft_gripper.diagrams.view.torque_legend import draw_torque_legend
from soft_gripper.diagrams.view.viewpoint import box_corners, nearest_eye, upright_view, viewing_direction
from soft_gripper.finger_links import link_name

PERIOD = 1 / 20  # s between frames
FIELD_OF_VIEW = np.radians(35)  # from the lower to the upper edge
_ASPECT = 1.5  # width over height of a window that still shows all
_ARROW_COLOR = Rgba(0.45, 0.1, 0.5)
_DIRECTION = np.array([-0.25, 1.0, -0.25])  # of sight, onto fingers alone
_MARGIN = 1.1
_FILL_LIGHT = np.array([-4.0, -3.0, -10.0])  # from which it shines: right, down and ahead of the camera, m
_FILL_INTENSITY = 1.4
_LEGEND_SHARE = 0.15  # of the height of the view, left free for the legend
# Corners, in B, of where a finger and its mount can be, in lengths of the finger.
_REACH = np.array([[x, 0, z] for x in (-0.5, 0.5) for z in (-0.3, 1.0)])


def add_meshcat_view(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    fingers: Sequence[PlantFinger],
    signals: Mapping[str, OutputPort],
    meshcat: Meshcat,
) -> None:
    """Adds the visualizers of bodies and of estimates, and sets the scene for them."""
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=PERIOD))
    ContactVisualizer.AddToBuilder(builder, plant, meshcat, _contact_arrows())
    drawn = [_drawn(scenario, plant, scene_graph, finger) for finger in fingers]
    limit = torque_limit(scenario, fingers)
    # After the visualizer of the bodies, which it colours.
    estimates = builder.AddNamedSystem("estimate_visualizer", EstimateVisualizer(meshcat, drawn, limit, PERIOD))
    builder.Connect(plant.get_body_poses_output_port(), estimates.GetInputPort("body_poses"))
    for finger in fingers:
        for name in (f"{finger.name}.arcs", f"{finger.name}.external_torque"):
            builder.Connect(signals[name], estimates.GetInputPort(name))
    direction = viewing_direction(scenario, plant, fingers, _DIRECTION)
    _set_scene(meshcat)
    if scenario.arm.model:
        _light_from_camera(meshcat, direction)
    _aim_camera(meshcat, _landmarks(scenario, plant, scene_graph, fingers), direction)
    draw_torque_legend(meshcat, limit, FIELD_OF_VIEW)


def _contact_arrows() -> ContactVisualizerParams:
    """True contact forces as arrows of 25 mm a newton; their moments are left out."""
    return ContactVisualizerParams(
        publish_period=PERIOD,
        newtons_per_meter=40.0,
        force_threshold=0.02,
        moment_threshold=np.inf,
        radius=0.8e-3,
        color=_ARROW_COLOR,
        hydro_force_color=_ARROW_COLOR,
    )


def torque_limit(scenario: Scenario, fingers: Sequence[PlantFinger]) -> float:
    """End of the scale of colours, N m: what the pressure supply can do to a joint, rounded up."""
    pressure = max(abs(scenario.pressure.minimum), abs(scenario.pressure.maximum))
    return round_limit(pressure * max(finger.finger.pressure_gain.max() for finger in fingers))


def _drawn(scenario: Scenario, plant: MultibodyPlant, scene_graph: SceneGraph, finger: PlantFinger) -> DrawnFinger:
    names = (link_name(finger.name, i) for i in range(finger.finger.segments + 1))
    links = [plant.GetBodyByName(name, finger.model).index() for name in names]
    skin = tuple(_shape_paths(plant, scene_graph, link) for link in links)
    return DrawnFinger(sensor_layout(scenario, finger), links[0], skin)


def _shape_paths(plant: MultibodyPlant, scene_graph: SceneGraph, body: int) -> tuple[str, ...]:
    """Where MeshcatVisualizer keeps the shapes of a body."""
    inspector = scene_graph.model_inspector()
    frame = plant.GetBodyFrameIdOrThrow(body)
    shapes = inspector.GetGeometries(frame, Role.kIllustration)
    names = (f"{inspector.GetName(frame)}::{inspector.GetName(shape)}" for shape in shapes)
    return tuple(f"/drake/visualizer/{name.replace('::', '/')}" for name in names)


def _set_scene(meshcat: Meshcat) -> None:
    """A plain, light background."""
    meshcat.SetProperty("/Background/<object>", "top_color", [1.0, 1.0, 1.0])
    meshcat.SetProperty("/Background/<object>", "bottom_color", [0.88, 0.9, 0.92])
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetProperty("/Axes", "visible", False)


def _landmarks(
    scenario: Scenario, plant: MultibodyPlant, scene_graph: SceneGraph, fingers: Sequence[PlantFinger]
) -> Array:
    """What is to be seen, (M, 3) m: where the fingers can go, the arm, and where its task begins and ends."""
    points = [finger.X_WB @ (finger.finger.length * corner) for finger in fingers for corner in _REACH]
    if scenario.arm.model:
        arm, context = plant.GetModelInstanceByName(scenario.arm.model), plant.CreateDefaultContext()
        models = {arm, *(finger.model for finger in fingers)}
        for posture in [scenario.arm.home, *(phase.posture for phase in scenario.task.phases if phase.posture)]:
            plant.SetPositions(context, arm, posture)
            points += [*box_corners(plant, scene_graph, context, models, Role.kIllustration)]
    if scenario.task.object:
        (begin,) = [model.X_PC for model in scenario.models if model.name == scenario.task.object]
        points += [place.GetDeterministicValue().translation() for place in (begin, scenario.task.X_WGoal)]
    return np.array(points)


def _aim_camera(meshcat: Meshcat, points: Array, direction: Array) -> None:
    """A camera that sees all points, (M, 3) m, above the legend."""
    meshcat.SetCamera(Meshcat.PerspectiveCamera(fov=np.degrees(FIELD_OF_VIEW)))
    view, edge = upright_view(direction), np.tan(FIELD_OF_VIEW / 2) / _MARGIN
    least, most = edge * np.array([-_ASPECT, -1.0]), edge * np.array([_ASPECT, 1.0 - 2 * _LEGEND_SHARE])
    eye = nearest_eye(points, view, least, most)
    middle = (np.min(points, axis=0) + np.max(points, axis=0)) / 2
    ahead = view.matrix()[:, 2]
    meshcat.SetCameraPose(eye, eye + ((middle - eye) @ ahead) * ahead)


def _light_from_camera(meshcat: Meshcat, direction: Array) -> None:
    """A brighter light from beside the camera; Meshcat's own stand where fingers alone are seen from."""
    meshcat.SetProperty("/Lights/FillLight/<object>", "position", [*upright_view(direction) @ _FILL_LIGHT])
    meshcat.SetProperty("/Lights/FillLight/<object>", "intensity", _FILL_INTENSITY)
