"""The view in Meshcat: what it shows, where it opens, and its configuration."""

import base64
import gzip
import re
import struct
from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.analysis import Simulator
from pydrake.visualization import VisualizationConfig
from refusals import refused
from waiting import wait_until
from websockets.sync.client import connect

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import run_station, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.view.estimate_visualizer import ARCS, CURVE
from soft_gripper.diagrams.view.meshcat_view import (
    FIELD_OF_VIEW,
    LOOPBACK,
    geometry_paths,
    hidden_meshcat,
    upright_view,
    write_animation,
)
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


def test_a_hidden_meshcat_is_elsewhere_each_time() -> None:
    first, second = hidden_meshcat(), hidden_meshcat()
    hosts = [urlsplit(meshcat.web_url()).hostname or "" for meshcat in (first, second)]
    assert all(host.startswith("127.") for host in hosts)
    assert len({LOOPBACK, *hosts}) == 3 or set(hosts) == {LOOPBACK}, "the loopback of macOS has one address"
    assert not {first.port(), second.port()} & set(range(7000, 7100))


HAS_SPRINGS = hasattr(VisualizationConfig(), "mouse_interaction_stiffness")


def test_a_run_with_it_is_that_without() -> None:
    short = ["pressure.settle=0.1", "pressure.hold_samples=5", "pressure.steps={all: [4.0e4]}"]
    seen, unseen = (
        simulate(load_scenario("free_bending", [*short, f"visualization={shown}"]), hidden_meshcat()).data
        for shown in ("{publish_period: 0.05}", "null")
    )
    np.testing.assert_array_equal(seen["plant.state"], unseen["plant.state"])


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("lcm_bus", "driver"),
        ("publish_illustration", "false"),
        ("enable_meshcat_creation", "false"),
        ("publish_period", "0"),
    ],
)
def test_what_a_view_cannot_do(field: str, value: str) -> None:
    with refused(f"visualization.{field}"):
        load_scenario("free_bending", [f"visualization.{field}={value}"])


@pytest.mark.skipif(not HAS_SPRINGS, reason="this Drake has no mouse springs")
def test_a_mouse_spring_pulls_a_finger() -> None:
    meshcat = hidden_meshcat()
    station = make_station(load_scenario("free_bending", ["visualization.mouse_interaction_stiffness=1000"]), meshcat)
    simulator = Simulator(station.diagram)
    tip = station.fingers[0].links[-1]
    context = station.plant.GetMyContextFromRoot(simulator.get_context())
    p_W, pull = tip.EvalPoseInWorld(context).translation(), np.array([0.03, 0.0, 0.0])
    path = geometry_paths(station.plant, station.parts.scene_graph, tip.index())[0]
    simulator.Initialize()
    with connect(meshcat.web_url().replace("http", "ws")) as client:
        client.send(_dragged(path, p_W, p_W + pull))
        spring = station.diagram.GetSubsystemByName("meshcat_mouse_spring")

        def forces() -> list[ExternallyAppliedSpatialForce]:
            return spring.get_output_port().Eval(spring.GetMyContextFromRoot(station.diagram.CreateDefaultContext()))

        wait_until(forces)
        (force,) = forces()
        assert force.body_index == tip.index()
        np.testing.assert_allclose(force.F_Bq_W.translational(), 1000 * tip.default_mass() * pull)  # N


def _dragged(path: str, p_W: np.ndarray, goal_W: np.ndarray) -> bytes:
    """The message of MessagePack that a browser sends while the mouse drags a geometry."""

    def text(of: str) -> bytes:
        return b"\xd9" + bytes([len(of)]) + of.encode()

    def numbers(of: np.ndarray) -> bytes:
        return b"\x93" + b"".join(b"\xcb" + struct.pack(">d", number) for number in of)

    parts = [text("type"), text("mouse_drag"), text("name"), text(path)]
    return b"\x84" + b"".join([*parts, text("drag_anchor"), numbers(p_W), text("drag_target"), numbers(goal_W)])
