"""What Meshcat holds after a run, and what an animation keeps of it."""

import base64
import gzip
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.view.estimate_visualizer import ARCS, CURVE
from soft_gripper.diagrams.view.meshcat_view import FIELD_OF_VIEW, upright_view, write_animation
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario


@pytest.fixture(scope="module")
def animation(tmp_path_factory: pytest.TempPathFactory) -> tuple[Meshcat, str]:
    """A short grasp shown in Meshcat, and the page of its animation."""
    meshcat, path = Meshcat(), tmp_path_factory.mktemp("animation") / "animation.html"
    short = ["pressure.steps.all=[50e3, 100e3]", "pressure.settle=0.1", "pressure.hold_samples=1"]
    run_station(make_station(load_scenario("box_grasp", short), meshcat), meshcat)
    write_animation(meshcat, path)
    return meshcat, unpacked(path)


def unpacked(path: Path) -> str:
    (packed,) = re.findall(r"base64,([A-Za-z0-9+/=]+)", path.read_text())
    return gzip.decompress(base64.b64decode(packed)).decode()


def test_meshcat_has_bodies_estimates_and_legend(animation: tuple[Meshcat, str]) -> None:
    meshcat, _ = animation
    for finger in ("left_finger", "right_finger"):
        for path in (
            f"{CURVE}/{finger}/0",
            f"{ARCS}/{finger}/0/unit/circle",
            f"/drake/visualizer/gripper/{finger}_link_12/gripper/Box/<object>",
            f"/drake/visualizer/gripper/{finger}_link_11/gripper/Cylinder/<object>",
        ):
            assert meshcat.HasPath(path), path
    assert meshcat.HasPath("/Cameras/default/rotated/<object>/legend")


def test_arcs_are_drawn_of_sections_or_of_segments() -> None:
    unequal = ["sensor.sections=2", "sensor.borders=[0.25]"]
    for more, sections in (([], 2), (["estimator.type=gaussian"], 12)):  # an arc a section, or a segment
        station = make_station(load_scenario("free_bending", [*unequal, *more]), Meshcat())
        visualizer = station.diagram.GetSubsystemByName("estimate_visualizer")
        for drawn in visualizer.fingers:
            assert drawn.sections == sections


def test_the_recording_holds_colors_poses_and_arcs(animation: tuple[Meshcat, str]) -> None:
    (animation,) = (data for data in payloads_of(animation[1]) if b"set_animation" in data)
    for track in (b".material.color[r]", b".position", b".quaternion", b".scale", b".rotation[y]", b".visible"):
        assert track in animation, track


def payloads_of(page: str) -> list[bytes]:
    return [base64.b64decode(data) for data in re.findall(r"octet-binary;base64,([A-Za-z0-9+/=]+)", page)]


class WatchedMeshcat(Meshcat):
    """Remembers where its camera was put."""

    def SetCameraPose(self, camera_in_world: Array, target_in_world: Array) -> None:  # noqa: N802
        self.eye, self.target = np.array(camera_in_world), np.array(target_in_world)
        super().SetCameraPose(camera_in_world, target_in_world)


@pytest.mark.slow
@pytest.mark.parametrize(
    "scenario",
    [
        load_scenario("box_grasp"),
        load_scenario("pick_and_place_box"),
        load_scenario("arm_motion"),
        replace(load_scenario("pick_and_place_apple"), task=None, external=["opening", "tool"]),
    ],
    ids=["grasp", "task", "arm", "open"],
)
def test_the_camera_sees_arm_gripper_object_and_goal_above_the_legend(scenario: Scenario) -> None:
    meshcat = WatchedMeshcat()
    station = make_station(scenario, meshcat)
    plant, context = station.plant, station.plant.CreateDefaultContext()
    view = upright_view(meshcat.target - meshcat.eye).matrix()
    task, arm = scenario.task, scenario.arm
    postures = [phase.posture for phase in task.phases if phase.posture] if task else []
    points = [[0.45, 0.18, 0.03], [0.45, -0.18, 0.03]] if task and task.object else []
    for posture in postures or [arm.home if arm else []]:
        if arm:
            plant.SetPositions(context, plant.GetModelInstanceByName(arm.model), posture)
        models = map(ModelInstanceIndex, range(2, plant.num_model_instances()))
        bodies = (plant.get_body(i) for m in models if plant.num_positions(m) for i in plant.GetBodyIndices(m))
        points += [plant.EvalBodyPoseInWorld(context, body).translation() for body in bodies]
    right, down, ahead = ((np.array(points) - meshcat.eye) @ view).T
    edge = np.tan(FIELD_OF_VIEW / 2)
    assert np.all(ahead > 0)
    assert np.max(np.abs(right / ahead)) < 1.5 * edge
    assert -0.98 * edge < np.min(down / ahead)
    assert 0.0 < np.max(down / ahead) < 0.75 * edge
