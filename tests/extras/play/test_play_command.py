"""soft-gripper play, as its user has it: a process, a page, sliders, and an end that leaves nothing.

And as an attacker has it, who can connect to every port of this machine.
"""

import json
import re
import signal
import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest
from browser import click, open_url
from served_page import SMALL_SCENE, Served, see
from waiting import LONG, wait_until
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

from soft_gripper.diagrams.recording import Recording

pytestmark = pytest.mark.slow

END = 10.0  # s from Ctrl-C to the end; 2 s where nothing else runs
PRESSURE, BEND = "left_finger.pressure", "left_finger.theta"
CONTROL, RELEASED = "\ue009", "\ue000"  # keys of WebDriver
BLUE = (0, 114, 178)  # of the first finger in the plots
DRAWN = """const [r, g, b] = arguments, figures = [...document.querySelectorAll("figure")];
const plot = figures.find((figure) => figure.querySelector("select").value === "pressure").querySelector("canvas");
const pixels = plot.getContext("2d").getImageData(0, 0, plot.width, plot.height).data;
let drawn = 0;
for (let i = 0; i < pixels.length; i += 4)
  drawn += Math.max(...[r, g, b].map((part, j) => Math.abs(pixels[i + j] - part))) < 40 && pixels[i + 3] > 60;
return drawn;"""  # pixels of a colour in the plot of pressures, edges of its lines included


class Played(Served):
    """A process that plays, and its page."""

    def __init__(self, out: Path):
        super().__init__("play", "free_bending", "--out", out)
        self.out = out


@pytest.fixture
def played(tmp_path: Path) -> Iterator[Played]:
    found = Played(tmp_path / "out")
    yield found
    if found.process.poll() is None:
        found.process.kill()
        found.process.wait()


@pytest.fixture
def driver(played: Played, tmp_path: Path) -> Iterator[Any]:
    """A browser that shows it, small, since there may be no graphics card."""
    driver = open_url(played.url, tmp_path / "profile", "820,400", SMALL_SCENE)
    driver.set_script_timeout(LONG)
    wait_until(lambda: driver.find_element("id", "mode").text == "live")
    yield driver
    driver.quit()


def is_drawn(driver: Any) -> bool:
    """Whether Meshcat shows the fingers: there is something below its path for bodies."""
    script = """const root = document.getElementById("scene").contentWindow.viewer?.scene_tree;
        return Object.keys(root?.find(["drake", "visualizer"]).children ?? {}).length > 0;"""
    return bool(driver.execute_script(script))


def test_a_user_plays_records_and_stops(played: Played, driver: Any) -> None:
    supply = (-50.0 + 210.0) / 2 * 1e3  # Pa, in the middle of the slider
    bend = played.value(BEND)
    wait_until(lambda: is_drawn(driver))
    click(driver, "[type=range][aria-label='left_finger [kPa]']")
    wait_until(lambda: abs(played.value(PRESSURE) - supply) < 1e3)
    assert abs(played.value("right_finger.pressure")) < 1e3
    assert played.value(BEND) > bend + 0.05, "the finger closes"

    click(driver, "#record")
    wait_until(lambda: driver.find_element("id", "mode").text == "live, recording")
    driver.find_element("tag name", "body").send_keys("q" * 3)
    driver.switch_to.frame("scene")
    driver.find_element("tag name", "body").send_keys("q" * 2)
    driver.switch_to.default_content()
    wait_until(lambda: abs(played.value(PRESSURE) - supply - 10e3) < 500)
    wait_until(lambda: driver.execute_script(DRAWN, *BLUE) > 50)
    number = driver.find_element("css selector", "[type=number][aria-label^='right_finger']")
    number.send_keys(CONTROL, "a", RELEASED, "-7.5\n")
    wait_until(lambda: abs(played.value("right_finger.pressure") + 7.5e3) < 100)
    click(driver, "#record")
    wait_until((played.out / "1" / "animation.html").exists)
    pressure = Recording.load(played.out / "1" / "recording.nc")[PRESSURE]
    assert pressure[-1] - pressure[0] == pytest.approx(10e3, abs=1.5e3)

    click(driver, "#stop")
    code, said = played.end()
    assert code == 0
    assert re.search(r"Played [\d.]+ s at [\d.]+ times real time", said)
    assert f"Recordings: {played.out / '1'}" in said
    wait_until(lambda: driver.find_element("id", "mode").text == "ended")


def attack(played: Played, clients: ExitStack) -> int:
    """Tries what a page from elsewhere can, with 100 connections that stay; how many of its sockets were opened."""
    opened = 0
    for path in ("", "live", "scene/", "a" * 22 + "/live"):
        for origin in ("http://evil.example", f"http://localhost:{played.port}", None):
            with suppress(OSError, WebSocketException):
                url = f"ws://localhost:{played.port}/{path}"
                with connect(url, origin=origin, proxy=None, open_timeout=LONG) as stranger:  # type: ignore[arg-type]
                    opened += 1
                    stranger.send(json.dumps({"slider": "left_finger [kPa]", "value": 56.0}))
                    stranger.send(json.dumps({"button": "record"}))
    for host in ("evil.example", "["):
        connection = HTTPConnection("127.0.0.1", played.port, timeout=LONG)
        connection.request("GET", urlsplit(played.url).path, headers={"Host": host})
        opened += connection.getresponse().status != 403
        connection.close()
    for i in range(100):
        client = clients.enter_context(socket.create_connection(("127.0.0.1", played.port), timeout=LONG))
        client.sendall([b"", b"G", b"\xc1" * 1000, b"GET / HTTP/1.1\r\n"][i % 4])
    return opened


def test_an_attacker_commands_nothing_writes_nothing_and_stops_nothing(played: Played) -> None:
    before = played.value(PRESSURE)
    with ExitStack() as clients, played.open() as page:
        assert attack(played, clients) == 0
        slow = [clients.enter_context(socket.create_connection(("127.0.0.1", played.port))) for _ in range(3)]
        page.send('{"slider": "left_finger [kPa]", "value": NaN}')
        page.send(b"\xc1")
        page.send(b"")
        page.send(json.dumps({"signals": [PRESSURE]}))
        wait_until(lambda: see(page)["values"])
        assert played.value(PRESSURE) == pytest.approx(before, abs=1.0)
        assert list(played.out.iterdir()) == [] or [f.name for f in played.out.iterdir()] == [".claim"]
        page.send(json.dumps({"button": "record"}))
        wait_until(lambda: see(page)["status"]["recording"])
        wait_until(lambda: see(page)["status"]["time"] > 0.3)
        began = time.monotonic()
        for number in (signal.SIGINT, signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            played.process.send_signal(number)
        while played.process.poll() is None:
            assert time.monotonic() - began < END, "the recording is written, and clients hold nothing up"
            for client in slow:
                with suppress(OSError):
                    client.sendall(b"G")
            time.sleep(0.05)
        code, said = played.end()
    assert code == 0
    assert "Traceback" not in said
    assert said.splitlines()[-1] == f"Recordings: {played.out / '1'}"
    assert (played.out / "1" / "animation.html").exists()
    assert Recording.load(played.out / "1" / "recording.nc")["time"][-1] > 0.25, "the last sample before the end"
