import math

import pytest
from live_station import played
from pydrake.systems.framework import Context

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.play.control_panel import ALL_FINGERS, Button, ControlPanel

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
