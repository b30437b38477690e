"""Figures of shapes and of sections: everything where it is, to scale."""

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon, Rectangle
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.finger_drawing import contact_arrow, estimated_contact
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_links import link_name
from soft_gripper.pictures.section_figure import section_figure
from soft_gripper.pictures.shape_figure import draw_band, shape_figure
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


def arrow_of(finger: Finger, force: float, s: float) -> Array | None:
    """Of a straight finger: across it is x."""
    ends = np.outer(finger.link_ends, [0.0, 0.0, 1.0])
    signals = {"contact_force": np.array([force]), "contact_arc_length": np.array([s])}
    return contact_arrow(finger, ends, estimated_contact(signals, ends))


@pytest.mark.parametrize(("force", "face"), [(0.5, "inner_face"), (-0.5, "outer_face")])
def test_an_arrow_begins_at_the_face_and_is_25_mm_a_newton(shipped_finger: Finger, force: float, face: str) -> None:
    arrow = arrow_of(shipped_finger, force, 0.08)
    assert arrow is not None
    np.testing.assert_allclose(arrow[0], [float(getattr(shipped_finger.section(0.08), face)), 0.0, 0.08], atol=1e-16)
    np.testing.assert_allclose(arrow[1] - arrow[0], [-0.025 * force, 0.0, 0.0], atol=1e-16)


def test_a_band_is_two_standard_deviations_wide_on_either_side(shipped_finger: Finger) -> None:
    axes, std = Figure().subplots(), np.linspace(0.1e-3, 1e-3, 13)
    draw_band(axes, np.stack([np.zeros(14), shipped_finger.link_ends], axis=-1), std)
    (band,) = (patch for patch in axes.patches if isinstance(patch, Polygon))
    inner, outer = np.split(band.get_xy(), 2)  # it ends where it begins
    np.testing.assert_allclose(inner[:, 0], 2e3 * np.concatenate([[0], std]))
    np.testing.assert_allclose(outer[::-1, 0], -inner[:, 0])
    np.testing.assert_allclose(inner[:, 1], 1e3 * shipped_finger.link_ends)


def rectangles(axes):
    """Left, bottom, width and height of all rectangles, mm."""
    patches = [patch for patch in axes.patches if isinstance(patch, Rectangle)]
    return [(*patch.get_xy(), patch.get_width(), patch.get_height()) for patch in patches]


def test_both_ends_are_drawn_as_built(shipped_finger):
    figure = section_figure(shipped_finger)
    assert len(figure.axes) == 2
    for axes, section in zip(figure.axes, (shipped_finger.base, shipped_finger.tip), strict=True):
        block, layer, chamber = rectangles(axes)
        walls = {name: 1e3 * float(wall) for name, wall in section.walls.items()}
        assert block[2:] == pytest.approx((1e3 * section.thickness, 1e3 * section.width))
        assert layer[2:] == pytest.approx((0.2, 1e3 * section.width))
        assert layer[0] + layer[2] == pytest.approx(block[0] + block[2])
        assert chamber[0] - block[0] == pytest.approx(walls["outer"])
        assert layer[0] - (chamber[0] + chamber[2]) == pytest.approx(walls["inner"])
        assert chamber[1] - block[1] == pytest.approx(walls["side"])
        written = {text.get_text() for text in axes.texts}
        assert {f"{wall:.3g}" for wall in walls.values()} <= written


def test_the_neutral_axis_and_the_sensors_are_where_the_finger_has_them(shipped_finger):
    axes = section_figure(shipped_finger).axes[1]
    axis, sensors = (line.get_xdata() for line in axes.lines)
    assert axis == pytest.approx(1e3 * float(shipped_finger.tip.neutral_axis))
    assert sensors - axis == pytest.approx([1e3 * offset for offset in shipped_finger.sensor_offsets])
