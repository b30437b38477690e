"""Drake's visualization beside our view: nothing is drawn twice, and mouse springs pull fingers."""

import struct

import numpy as np
import pytest
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.analysis import Simulator
from pydrake.visualization import VisualizationConfig
from refusals import refused
from waiting import wait_until
from websockets.sync.client import connect

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.view.meshcat_view import geometry_paths, hidden_meshcat
from soft_gripper.scenario.scenario_file import load_scenario

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
