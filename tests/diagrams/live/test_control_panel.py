import pytest
from live_station import click, move, played
from pydrake.geometry import Meshcat
from pydrake.systems.framework import Context

from soft_gripper.diagrams.live.control_panel import ALL_FINGERS, Button, ControlPanel
from soft_gripper.diagrams.station_parts import Station


@pytest.fixture(scope="module")
def shown() -> tuple[Station, Meshcat, ControlPanel]:
    station, meshcat = played("box_grasp")
    return station, meshcat, ControlPanel(meshcat, station)


def commanded(station: Station, panel: ControlPanel, context: Context | None = None) -> list[float]:
    """Pressures that the fingers are given, kPa."""
    context = context or station.diagram.CreateDefaultContext()
    panel.apply(context)
    ports = (station.diagram.GetOutputPort(f"{side}_finger.pressure_command") for side in ("left", "right"))
    return [port.Eval(context)[0] / 1e3 for port in ports]


def test_a_slider_moves_its_finger(shown) -> None:
    station, meshcat, panel = shown
    panel.reset()
    assert commanded(station, panel) == [0, 0]
    move(meshcat, "left_finger [kPa]", 40.0)
    assert commanded(station, panel) == [40, 0]


def test_one_slider_moves_all_fingers_when_it_is_moved(shown) -> None:
    station, meshcat, panel = shown
    panel.reset()
    move(meshcat, ALL_FINGERS, 60.0)
    assert commanded(station, panel) == [60, 60]
    move(meshcat, "right_finger [kPa]", -20.0)
    assert commanded(station, panel) == [60, -20], "a finger of its own leaves it again"


def test_reset_moves_all_sliders_back(shown) -> None:
    station, meshcat, panel = shown
    move(meshcat, ALL_FINGERS, 60.0)
    commanded(station, panel)
    panel.reset()
    assert commanded(station, panel) == [0, 0]
    assert meshcat.GetSliderValue(ALL_FINGERS) == 0


def test_a_click_counts_once(shown) -> None:
    _, meshcat, panel = shown
    assert panel.pressed() == []
    click(meshcat, Button.RESET)
    click(meshcat, Button.PAUSE)
    assert panel.pressed() == [Button.PAUSE, Button.RESET]
    assert panel.pressed() == []


def test_keys_move_their_slider_up_and_down(shown) -> None:
    keys = {}

    class Controls:
        def AddSlider(self, name, *_, decrement_keycode, increment_keycode) -> None:  # noqa: N802
            keys[name] = (decrement_keycode, increment_keycode)

        def AddButton(self, name, key) -> None:  # noqa: N802
            keys[name] = key

        def GetSliderValue(self, _) -> float:  # noqa: N802
            return 0.0

    ControlPanel(Controls(), shown[0])
    assert keys[ALL_FINGERS] == ("ArrowDown", "ArrowUp")
    assert keys["left_finger [kPa]"] == ("KeyA", "KeyQ")
    assert keys[Button.PAUSE] == "KeyP"


def test_a_single_finger_has_no_slider_of_all() -> None:
    station, meshcat = played(
        "free_bending", None, "models=[{name: f, file: package://soft_gripper/grippers/finger.urdf}]"
    )
    assert [slider.name for slider in ControlPanel(meshcat, station).sliders] == ["f [kPa]"]
    assert meshcat.GetSliderValue("f [kPa]") == 0
