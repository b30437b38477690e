"""The page in a browser: whatever it shows, its buttons keep their place, so that a click hits what was aimed at."""

from collections.abc import Iterator
from typing import Any

import pytest
from browser import open_url
from pydrake.systems.primitives import PassThrough
from waiting import wait_until

from soft_gripper.commands.page_server import page_server
from soft_gripper.extras.page.live_page import SessionPage, page_contents
from soft_gripper.extras.page.panel import Button, Panel, Slider
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.scenario.schema import Scenario
from soft_gripper.signals import describe

pytestmark = pytest.mark.slow

SIGNALS = {f"{finger}.theta": describe(PassThrough(1).get_output_port(), "rad") for finger in ("left", "right")}
BOXES = """return Object.fromEntries([...document.querySelectorAll("button, input, select")].map(
    (control, i) => [control.id || i, Object.values(control.getBoundingClientRect().toJSON())]));"""
NO_SCENE = "http://127.0.0.1:1"  # nothing to draw, which takes long without a graphics card
QUIET = {"recording": False, "paused": False, "note": "", "time": 0.0, "factor": 1.0}
HEAD, ROW = ["", "left", "right"], ["calibration", "within, 0.1 spreads away", "far, 12.3 spreads away"]
STATUSES: dict[str, dict[str, Any]] = {
    "paused": {"paused": True},
    "zeroing": {"zeroing": True, "mode": "zeroing"},
    "recording": {"recording": True, "mode": "waiting for readings", "time": 12345.6},
    "long pace": {"latency": "reading to result 1234.5 ms; oldest command in force: none but safe ones " * 2},
    "long note": {"note": "zeroed: the sensors now read those of fingers that hang free; written: a/b/c " * 9},
    "tables": {"tables": [["estimates", HEAD, ROW], ["readings", [], ["used", "1", "lost", "2"]]]},
    "longer tables": {"tables": [["estimates", HEAD, *[ROW] * 20], ["readings", [], ["used", "1234567", "lost", "2"]]]},
}


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Any, SignalFeed]]:
    """A browser with a page that has all buttons with a state, and what feeds it."""
    buttons = Button.PAUSE, Button.ZERO, Button.RECORD, Button.STOP
    panel, feed = Panel(buttons, [Slider("left [kPa]", -50.0, 200.0, 5.0, 0.0)]), SignalFeed(SIGNALS)
    scenario = Scenario(description="Two fingers close on a box that rests on a table")
    page = SessionPage(page_contents("play", "box", scenario, panel, SIGNALS, ["left", "right"]), panel, feed)
    with page_server("127.0.0.1", lambda: NO_SCENE, page) as url:
        driver = open_url(url, tmp_path_factory.mktemp("profile"))
        wait_until(lambda: len(boxes(driver)) == 9 and feed.wanted_signals)
        yield driver, feed
        driver.quit()


def boxes(driver: Any) -> dict[str, list[float]]:
    """The place and size of every control in the window, px."""
    found: dict[str, list[float]] = driver.execute_script(BOXES)
    return found


def show(shown: tuple[Any, SignalFeed], status: dict[str, Any]) -> dict[str, list[float]]:
    """The controls once the page shows a status, which its time tells."""
    driver, feed = shown
    message = {**QUIET, "sliders": {"left [kPa]": 0.0}, **status}

    def is_shown() -> bool:
        feed.send(message, {})
        text: str = driver.find_element("id", "time").text
        return text == f"{message['time']:.1f} s"

    wait_until(is_shown)
    return boxes(driver)


@pytest.mark.parametrize("width", [390, 900, 1400])
def test_controls_keep_their_place(shown: tuple[Any, SignalFeed], width: int) -> None:
    size = {"width": width, "height": 700, "deviceScaleFactor": 1, "mobile": False}
    shown[0].execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    before = show(shown, {"time": 1.0})
    assert all(x + control_width <= width for x, _, control_width, *_ in before.values())
    for number, (name, status) in enumerate(STATUSES.items()):
        assert show(shown, {"time": 2.0 + number, **status}) == before, name
