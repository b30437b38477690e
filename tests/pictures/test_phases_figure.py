"""The figure of a task shows every phase's end, the path of the object and the signals, as they were recorded."""

from collections.abc import Sequence

import numpy as np
import pytest
from matplotlib.axes import Axes
from pydrake.trajectories import PiecewisePolynomial
from scenes import Scene

from soft_gripper.control.task import Phase
from soft_gripper.diagrams.recording import Recording
from soft_gripper.pictures import phases as module
from soft_gripper.pictures.phases import phases_figure
from soft_gripper.pictures.rendering import SceneRenderer

pytestmark = pytest.mark.slow

HOME, THERE = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0], [0.2, -1.2, 1.6, -2.0, -1.57, 0.3]
LIFT, CARRY = np.array([0.0, 0.0, 0.1]), np.array([0.05, 0.3, 0.0])  # m
TORQUES = np.full(12, -0.05)  # N m
Run = tuple[Scene, Recording, list[Phase]]


def phase(name: str, goal: Sequence[float]) -> Phase:
    return Phase(name, PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.array([HOME, goal]).T), 0.05, 0)


@pytest.fixture(scope="module")
def run() -> Run:
    """The box is lifted, carried in two steps and put down; then the arm goes home, and the task is over."""
    scene = Scene("pick_and_place_box")
    scene.scenario.control.torque_limit = 0.07
    states = [scene.state()]
    scene.pose_arm(THERE)
    for shift in (0 * LIFT, LIFT, 0.6 * CARRY, 0.4 * CARRY, -LIFT):
        scene.move("box", shift)
        states.append(scene.state())
    scene.pose_arm(HOME)
    states += [scene.state(), scene.state()]
    phases = [phase("reach", THERE), phase("take", THERE), phase("carry", THERE), phase("return", HOME)]
    signals = {
        "task.phase": [0, 0, 1, 2, 2, 3, 4, 4],
        "grip.set_point": 1e-3 * np.array([50, 50, 20, 20, 20, 20, 60, 60]),
        "grip.opening": 1e-3 * np.array([90, 50, 42, 41, 40, 40, 55, 60]),
        "grip.torque": 1e-3 * np.array([0, 1, 60, 65, 66, 64, 2, 1]),
        **{f"{finger}.pressure_command": 1e3 * np.arange(8) for finger in scene.fingers},
        **{f"{finger}.pressure": 0.9e3 * np.arange(8) for finger in scene.fingers},
    }
    return scene, scene.recording(*states, torques=TORQUES, signals=signals), phases


@pytest.fixture(scope="module")
def panels(run: Run) -> list[Axes]:
    scene, recording, phases = run
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "DPI", 40)
        return phases_figure(scene.scenario, recording, phases).axes


def test_the_path_is_that_of_the_object(run: Run, panels: list[Axes]) -> None:
    scene, recording, _ = run
    height, width, _ = np.array(panels[0].images[0].get_array()).shape
    camera = SceneRenderer(scene.scenario, recording, height, width).camera
    box = scene.plant.GetBodyByName("box")
    context = scene.plant.CreateDefaultContext()
    for end, state in ((0, 0), (-1, -1)):
        scene.plant.SetPositionsAndVelocities(context, recording["plant.state"].values[state])
        pixel = camera.project(box.EvalPoseInWorld(context).translation())
        np.testing.assert_allclose(panels[0].lines[0].get_xydata()[end], pixel)


def test_the_plots_are_what_was_recorded(run: Run, panels: list[Axes]) -> None:
    _, recording, _ = run
    opening, torque, pressure = panels[5:8]
    for axes, label, signal, unit in (
        (opening, "set point", "grip.set_point", 1e3),
        (opening, "estimated", "grip.opening", 1e3),
        (torque, "estimated", "grip.torque", 1e3),
        (pressure, "command", "left_finger.pressure_command", 1e-3),
        (pressure, "in the fingers", "right_finger.pressure", 1e-3),
    ):
        (line,) = [line for line in axes.lines if line.get_label() == label]
        np.testing.assert_allclose(line.get_xydata(), np.column_stack([np.arange(8), unit * recording[signal]]))
    levels = {line.get_label(): line.get_ydata()[0] for line in torque.lines}
    assert (levels["limit"], levels["grip threshold"]) == pytest.approx((70, 20))
    assert {axes.get_xlim() for axes in (opening, torque, pressure)} == {(0.0, 7.0)}
