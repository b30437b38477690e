"""The figure of a finger's shape draws what was recorded."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Polygon
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.torque_colors import color
from soft_gripper.fingers.finger_links import link_name
from soft_gripper.pictures.shape_figure import shape_figure
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.sensor_layout import SensorLayout

SECTIONS = 3
TIME = 0.4  # s
Run = tuple[Station, Recording]


@pytest.fixture(scope="module")
def run() -> Run:
    """The left finger along its path, to close round the peg that obstructs it."""
    steps = ("pressure.steps.all=[100e3]", "pressure.settle=0.49", "pressure.hold_samples=1")
    station = make_station(load_scenario("obstructed_inside", [*steps, f"sensor.sections={SECTIONS}"]))
    return station, run_station(station)


@pytest.fixture(scope="module")
def panels(run: Run) -> list[Axes]:
    return shape_figure(layout_of(run), run[1], TIME).axes


def layout_of(run: Run) -> SensorLayout:
    station, _ = run
    return sensor_layout(station.fingers[0].finger, station.scenario.sensor)


def recorded(run: Run, signal: str) -> Array:
    values: Array = run[1][f"left_finger.{signal}"].sel(time=TIME, method="nearest").values
    return values


def drawn(axes: Axes, label: str) -> Array:
    """The points of a line, (M, 2) mm."""
    (line,) = [line for line in axes.lines if str(line.get_label()).startswith(label)]
    return np.transpose(line.get_data())


def test_estimated_joints_are_the_recorded_ones(run: Run, panels: list[Axes]) -> None:
    np.testing.assert_allclose(drawn(panels[1], "estimated joints"), 1e3 * recorded(run, "joint_positions"))


def test_true_joints_are_where_drake_has_them(run: Run, panels: list[Axes]) -> None:
    station, recording = run
    plant, finger = station.plant, station.fingers[0]
    context = plant.CreateDefaultContext()
    # What is sampled at a time is read until the next sample, and there still recorded.
    state = recording["plant.state"].sel(time=TIME - station.scenario.sensor.period, method="nearest")
    plant.SetPositionsAndVelocities(context, state.values)
    links = [plant.GetBodyByName(link_name("left_finger", i), finger.model) for i in range(1, 13)]
    X_BW: RigidTransform = finger.X_WB.inverse()
    p_BJ = np.array([(X_BW @ link.EvalPoseInWorld(context)).translation() for link in links])
    np.testing.assert_allclose(drawn(panels[1], "true joints"), 1e3 * p_BJ[:, [0, 2]], atol=1e-6)


@pytest.mark.parametrize(
    ("panel", "patch", "signal"), [(0, FancyBboxPatch, "true_external_torque"), (2, Polygon, "external_torque")]
)
def test_torques_have_their_colours(run: Run, panels: list[Axes], panel: int, patch: type, signal: str) -> None:
    bar = panels[3]
    limit = bar.get_ylim()[1] / 1e3
    both = recorded(run, "true_external_torque"), recorded(run, "external_torque")
    assert limit == pytest.approx(np.abs(both).max())
    assert limit > 0.02
    pieces = [p for p in panels[panel].patches if isinstance(p, patch) and p.get_fill()]
    expected = color(recorded(run, signal), limit)
    np.testing.assert_allclose([to_rgb(piece.get_facecolor()) for piece in pieces], expected)


def arrows(axes: Axes) -> list[FancyArrowPatch]:
    return [patch for patch in axes.patches if isinstance(patch, FancyArrowPatch)]


@pytest.fixture(scope="module")
def grasped() -> Run:
    """Fingers in space on a box that is turned, after 0.8 s, with sensors and an estimator in space."""
    sensors = ["sensor.layout=four_faces_and_diagonal", "sensor.sections=4", "estimator.type=contact"]
    steps = ["pressure.steps.all=[90e3]", "pressure.settle=0.79", "pressure.hold_samples=1"]
    station = make_station(load_scenario("turned_box_grasp", [*sensors, *steps]))
    return station, run_station(station)


@pytest.mark.slow
def test_an_estimate_in_space_is_drawn_from_the_side_where_it_is(grasped: Run) -> None:
    """Its segments lie on the estimated joints, and its arrow is the estimated force, 25 mm/N."""
    station, recording = grasped
    finger, now = station.fingers[0].finger, recording.data.sel(time=0.8, method="nearest")
    panels = shape_figure(sensor_layout(finger, station.scenario.sensor), recording, 0.8).axes
    joints = 1e3 * now["left_finger.estimated_joint_positions"].values
    assert np.ptp(joints[:, 1]) > 1
    force = 25 * now["left_finger.contact_force_vector"].values
    assert abs(force[1]) > 1
    for axes, seen in ((panels[2], [0, 2]), (panels[4], [1, 2])):
        segments = [patch for patch in axes.patches if isinstance(patch, FancyBboxPatch)]
        middles = [patch.get_transform().transform((0, 0)) for patch in segments]
        place = axes.transData.inverted().transform(middles)
        np.testing.assert_allclose(place[:, 1], joints[:, 2], atol=0.15)
        if seen[0]:
            np.testing.assert_allclose(place[:, 0], joints[:, 1], atol=0.15)
        estimated, _ = sorted(arrows(axes), key=lambda patch: patch.get_linewidth())
        begin, end = estimated._posA_posB
        np.testing.assert_allclose(np.subtract(end, begin), force[seen], atol=1e-6)
