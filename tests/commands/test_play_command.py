"""soft-gripper play, as its user has it: a process, a page, sliders, and an end that leaves nothing."""

import json
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import pytest
from browser import open_url
from command_line import LISTENING, soft_gripper

from soft_gripper.diagrams.recording.recording import Recording

pytestmark = pytest.mark.slow

LONG = 120.0  # s, for whatever a busy machine may take
PRESSURE, BEND = "left_finger.pressure", "left_finger.theta"
ROW = "//li[contains(@class, 'cr')][.//span[@class='property-name' and starts-with(text(), '{}')]]"  # of controls
BLUE = (0, 114, 178)  # of the first finger in the plots
DRAWN = """const plot = document.querySelector("canvas"), [r, g, b] = arguments;
const pixels = plot.getContext("2d").getImageData(0, 0, plot.width, plot.height).data;
let drawn = 0;
for (let i = 0; i < pixels.length; i += 4)
  drawn += Math.max(...[r, g, b].map((part, j) => Math.abs(pixels[i + j] - part))) < 40 && pixels[i + 3] > 200;
return drawn;"""  # pixels of a colour in the first plot


class Played:
    """A process that plays, and its page."""

    def __init__(self, out: Path):
        command = [*LISTENING, "play", "free_bending", "--out", str(out)]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert self.process.stdout is not None
        (port,) = re.findall(r"http://localhost:(\d+)", self.process.stdout.readline())
        self.port, self.out = int(port), out
        self.url = f"http://localhost:{port}"

    def message(self, *signals: str) -> dict[str, Any]:
        """How things are, and the values of some signals."""
        connection = HTTPConnection("127.0.0.1", self.port, timeout=LONG)
        connection.request("GET", "/live?" + "&".join(f"signal={name}" for name in signals))
        line = connection.getresponse().readline().decode()
        connection.close()
        found: dict[str, Any] = json.loads(line.removeprefix("data: "))
        return found

    def value(self, name: str) -> float:
        """The first entry of a signal."""
        return float(self.message(name)["values"][name][0])

    def end(self) -> tuple[int, str]:
        """Its exit code and what it has said, once it has ended; its port is then free."""
        said, _ = self.process.communicate(timeout=LONG)
        with pytest.raises(ConnectionRefusedError):
            HTTPConnection("127.0.0.1", self.port).connect()
        return self.process.returncode, said


@pytest.fixture
def played(tmp_path: Path) -> Iterator[Played]:
    found = Played(tmp_path / "out")
    yield found
    if found.process.poll() is None:
        found.process.kill()
        found.process.wait()


def wait_until(holds: Callable[[], object]) -> None:
    deadline = time.monotonic() + LONG
    while not holds():
        assert time.monotonic() < deadline, "it takes too long"
        time.sleep(0.1)


@pytest.fixture
def driver(played: Played, tmp_path: Path) -> Iterator[Any]:
    """A browser that shows it, small, since there may be no graphics card."""
    driver = open_url(played.url, tmp_path / "profile", "820,400")
    driver.set_script_timeout(LONG)
    wait_until(lambda: driver.find_element("id", "mode").text == "live")
    driver.switch_to.frame("scene")
    wait_until(lambda: driver.find_elements("xpath", ROW.format("left_finger")))
    yield driver
    driver.quit()


def control(driver: Any, name: str) -> Any:
    """What is to be clicked of a slider, in its middle, or of a button."""
    row = driver.find_element("xpath", ROW.format(name))
    return next(iter(row.find_elements("css selector", ".slider")), row)


def test_a_user_plays_records_and_stops(played: Played, driver: Any) -> None:
    supply = (-50.0 + 210.0) / 2 * 1e3  # Pa, in the middle of the slider
    bend = played.value(BEND)
    control(driver, "left_finger").click()
    wait_until(lambda: abs(played.value(PRESSURE) - supply) < 1e3)
    assert abs(played.value("right_finger.pressure")) < 1e3
    assert played.value(BEND) > bend + 0.05, "the finger closes"

    control(driver, "record").click()
    driver.switch_to.default_content()
    wait_until(lambda: driver.find_element("id", "mode").text == "live, recording")
    driver.find_element("tag name", "body").send_keys("q" * 5)
    wait_until(lambda: abs(played.value(PRESSURE) - supply - 10e3) < 500)
    wait_until(lambda: driver.execute_script(DRAWN, *BLUE) > 50)
    driver.switch_to.frame("scene")
    control(driver, "record").click()
    wait_until((played.out / "1" / "replay.html").exists)
    pressure = Recording.load(played.out / "1" / "recording.nc")[PRESSURE]
    assert pressure[-1] - pressure[0] == pytest.approx(10e3, abs=1.5e3)

    control(driver, "stop").click()
    code, said = played.end()
    assert code == 0
    assert re.search(r"Played [\d.]+ s at [\d.]+ times real time", said)
    driver.switch_to.default_content()
    wait_until(lambda: driver.find_element("id", "mode").text == "ended")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_signals_end_it(played: Played, number: signal.Signals, code: int) -> None:
    assert played.message()["status"]["factor"] > 0
    played.process.send_signal(number)
    ended, said = played.end()
    assert ended == code
    assert "Traceback" not in said


ALONE = "models=[{name: f, file: package://soft_gripper/grippers/finger.urdf}]"


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (("--set", ALONE, "--grip", "opening"), "needs two fingers or more that stand fixed to each other"),
        (("--host", "192.0.2.1"), "192.0.2.1"),
    ],
)
def test_what_cannot_be_played_is_refused(options: tuple[str, ...], complaint: str, tmp_path: Path) -> None:
    found = soft_gripper("play", "free_bending", "--out", tmp_path / "out", *options)
    assert (found.code, found.err.count("\n")) == (2, 1)
    assert complaint in found.err
