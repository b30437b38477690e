"""The control panel: its sliders, what they command, what is refused."""

import math

import numpy as np
import pytest
from live_station import played
from pydrake.systems.framework import Context

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.play.control_panel import (
    ALL_FINGERS,
    NO_KEYS,
    Button,
    ControlPanel,
    SliderCommand,
    pressure_slider,
    slider_commands,
)
from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import PressureConfig

LEFT, RIGHT = "left_finger [kPa]", "right_finger [kPa]"


@pytest.fixture(scope="module")
def station() -> Station:
    return played("box_grasp")[0]


@pytest.fixture
def panel(station: Station) -> ControlPanel:
    return ControlPanel(station)


def move(panel: ControlPanel, slider: str, value: object) -> bool:
    return panel.take({"slider": slider, "value": value})


def commanded(station: Station, panel: ControlPanel, context: Context | None = None) -> list[float]:
    """Pressures that the fingers are given, kPa."""
    context = context or station.diagram.CreateDefaultContext()
    panel.apply(station, context)
    ports = (station.diagram.GetOutputPort(f"{side}_finger.pressure_command") for side in ("left", "right"))
    return [port.Eval(context)[0] / 1e3 for port in ports]


def test_a_slider_moves_its_finger(station: Station, panel: ControlPanel) -> None:
    assert commanded(station, panel) == [0, 0]
    assert move(panel, LEFT, 40.5)
    assert commanded(station, panel) == [40.5, 0]
    assert move(panel, LEFT, 40)
    assert commanded(station, panel) == [40, 0]


def test_one_slider_moves_all_fingers_when_it_is_moved(station: Station, panel: ControlPanel) -> None:
    move(panel, ALL_FINGERS, 60.0)
    assert commanded(station, panel) == [60, 60]
    move(panel, RIGHT, -20.0)
    assert commanded(station, panel) == [60, -20], "a finger of its own leaves it again"
    assert panel.values == {ALL_FINGERS: 60, LEFT: 60, RIGHT: -20}


def test_a_click_counts_once(panel: ControlPanel) -> None:
    assert panel.take_clicks() == []
    assert panel.take({"button": "reset"})
    assert panel.take({"button": "pause"})
    assert panel.take_clicks() == [Button.PAUSE, Button.RESET]
    assert panel.take_clicks() == []


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e9, -51, 211, True, "60", None, [60], {}])
def test_a_value_that_a_slider_cannot_have_is_refused(panel: ControlPanel, value: object) -> None:
    before = panel.values
    assert not move(panel, ALL_FINGERS, value)
    assert not move(panel, LEFT, value)
    assert panel.values == before


@pytest.mark.parametrize(
    "message",
    [
        None, 1.0, "stop", [], {}, {"slider": LEFT}, {"value": 1.0}, {"slider": "middle_finger [kPa]", "value": 1.0},
        {"slider": 1, "value": 1.0}, {"button": "explode"}, {"button": None}, {"button": ["stop"]}, {"button": "STOP"},
        {"button": "stop", "slider": LEFT, "value": 1.0}, {"type": "slider", "name": LEFT, "value": 1.0},
    ],
)  # fmt: skip
def test_what_is_no_command_is_refused(panel: ControlPanel, message: object) -> None:
    before = panel.values
    assert not panel.take(message)
    assert panel.values == before
    assert panel.take_clicks() == []


def test_chambers_and_tendons_have_sliders_of_their_own() -> None:
    several = played("three_chambers")[0]
    panel = ControlPanel(several)
    names = [f"finger {chamber} [kPa]" for chamber in ("inner", "left", "right")]
    assert [slider.name for slider in panel.sliders] == names
    move(panel, names[1], 30.0)
    context = several.diagram.CreateDefaultContext()
    panel.apply(several, context)
    assert several.diagram.GetOutputPort("finger.pressure_command").Eval(context).tolist() == [0, 30e3, 0]


@pytest.mark.parametrize(("kind", "unit", "value", "expected"), [("tension", "N", 2.0, 2.0), ("pull", "mm", 6.0, 6e-3)])
def test_tendons_are_pulled_by_sliders(kind: str, unit: str, value: float, expected: float) -> None:
    pulled = played(
        "tendon_grasp", None, f"tendons.command={kind}", "tendons.steps.all=[0.0]", "plant_config.time_step=0.005"
    )[0]
    panel = ControlPanel(pulled)
    assert ALL_FINGERS not in panel.values
    assert move(panel, f"right_finger flexor [{unit}]", value)
    context = pulled.diagram.CreateDefaultContext()
    panel.apply(pulled, context)
    assert pulled.diagram.GetOutputPort(f"right_finger.{kind}_command").Eval(context) == pytest.approx([expected])


@pytest.fixture(scope="module")
def box() -> Station:
    return make_station(open_scenario(load_scenario("box_grasp")))


@pytest.fixture(scope="module")
def arm() -> Station:
    return make_station(open_scenario(load_scenario("arm_motion")))


def at_start(command: SliderCommand):
    return command.value([slider.value for slider in command.sliders])


def test_every_open_input_has_a_command(box: Station, arm: Station) -> None:
    for station in (box, arm):
        assert {command.port for command in slider_commands(station.parts)} == set(station.parts.inputs)


def test_a_pressure_for_every_finger(box: Station) -> None:
    left, right = slider_commands(box.parts)
    assert (left.port, right.port) == ("left_finger.pressure_command", "right_finger.pressure_command")
    assert left.value([60.0]) == [60e3]
    supply = box.scenario.pressure
    assert [1e3 * left.sliders[0].low, 1e3 * left.sliders[0].high] == [supply.minimum, supply.maximum]


@pytest.mark.parametrize(("low", "high", "begin"), [(-40e3, 150e3, 0.0), (10e3, 20e3, 10.0), (-50e3, -5e3, -5.0)])
def test_pressure_begins_as_near_to_none_as_the_supply_comes(low: float, high: float, begin: float) -> None:
    assert pressure_slider("a", PressureConfig(minimum=low, maximum=high), NO_KEYS).value == begin


def test_the_opening_begins_at_that_of_straight_fingers(arm: Station) -> None:
    command = slider_commands(arm.parts)[0]
    bases = [finger.X_WB.translation() for finger in arm.fingers]
    np.testing.assert_allclose(at_start(command), np.linalg.norm(bases[0] - bases[1]), rtol=1e-9)


def test_the_tool_begins_where_the_arm_holds_it(arm: Station) -> None:
    plant, context = arm.plant, arm.plant.CreateDefaultContext()
    gripper = plant.GetModelInstanceByName("gripper")
    X_WTool = plant.EvalBodyPoseInWorld(context, plant.get_body(plant.GetBodyIndices(gripper)[0]))
    assert at_start(slider_commands(arm.parts)[1]).IsNearlyEqualTo(X_WTool, 1e-9)


def test_no_key_does_two_things(box: Station, arm: Station) -> None:
    for station in (box, arm):
        keys = [key for command in slider_commands(station.parts) for slider in command.sliders for key in slider.keys]
        assert len(keys) == len(set(keys))
