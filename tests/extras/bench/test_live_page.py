"""soft-gripper live --page in a browser: a user zeroes, records and stops a session."""

import json
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
import simulated_hardware
import yaml
from browser import click, open_url
from live_process import free_port
from served_page import SMALL_SCENE, Served
from waiting import LONG, wait_until

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.hardware.bench_schema import described
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

IN_SCENE = """const root = document.getElementById("scene").contentWindow.viewer?.scene_tree;
return Object.keys(root?.find(arguments[0]).children ?? {}).length > 0;"""


@pytest.fixture
def served(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Served]:
    monkeypatch.chdir(tmp_path)
    commands, readings = free_port(), free_port()
    changes = ("tip_distance_steps", "--set", "estimator.type=gaussian", "--set", "sensor.sections=2")
    hardware = [sys.executable, simulated_hardware.__file__, *changes]
    hardware += ["--source", f"udp://:{commands}", "--sink", f"udp://127.0.0.1:{readings}"]
    config = described(Bench(load_scenario(changes[0], changes[2::2])).inputs, f"udp://:{readings}")
    config.sink = f"udp://127.0.0.1:{commands}"
    Path("bench.yaml").write_text(yaml.dump(asdict(config)))
    with subprocess.Popen(hardware) as process:
        found = Served("live", *changes, "--bench", "bench.yaml", "--page")
        yield found
        process.kill()
        if found.process.poll() is None:
            found.process.kill()
            found.process.wait()


def test_a_user_zeroes_records_and_stops(served: Served, tmp_path: Path) -> None:
    driver: Any = open_url(served.url, tmp_path / "profile", "900,700", SMALL_SCENE)
    try:
        driver.set_script_timeout(LONG)
        wait_until(lambda: "mm" in text(driver, "tables"))
        assert driver.title == "tip_distance_steps - soft-gripper live"
        for path in (["drake", "visualizer"], ["drake", "estimate", "band"]):
            wait_until(lambda path=path: driver.execute_script(IN_SCENE, path))
        assert re.search(r"reading to result [\d.]+ ms", text(driver, "pace"))
        assert "left_finger" in text(driver, "tables")
        assert re.search(r"used\s+\d+\s+lost\s+\d+", text(driver, "tables"))

        click(driver, "#zero")
        wait_until(lambda: text(driver, "note").startswith("zeroed:"))
        driver.find_element("tag name", "body").send_keys("c")
        wait_until(lambda: "recording" in text(driver, "mode"))
        began = time_of(driver)
        wait_until(lambda: time_of(driver) > began + 0.5)
        click(driver, "#record")
        folder = Path("results/live/tip_distance_steps/1")
        wait_until(lambda: text(driver, "note") == f"written: {folder / 'recording.nc'}")
        recording = Recording.load(folder / "recording.nc")
        assert recording["time"][0] == 0
        assert recording["time"][-1] > 0.1  # of half a second, on a machine however busy
        assert recording["left_finger.position_std"].attrs["units"] == "m"

        assert [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"] == []
        click(driver, "#stop")
        code, said = served.end()
        assert code == 0
        assert f"Recordings: {folder}" in said
        assert re.search(r"Readings: \d+ used", said)
        wait_until(lambda: text(driver, "mode") == "ended")
    finally:
        driver.quit()


def time_of(driver: Any) -> float:
    """What the page says, s."""
    return float(text(driver, "time").removesuffix(" s"))


def text(driver: Any, name: str) -> str:
    found: str = driver.find_element("id", name).text
    return found


def test_the_page_needs_its_token_and_takes_known_buttons_alone(served: Served) -> None:
    with served.open() as page:
        for junk in ({"button": "pause"}, {"button": "reset"}, {"slider": "opening [mm]", "value": 1.0}, "x"):
            page.send(json.dumps(junk))
        page.send(json.dumps({"button": "stop"}))
        code, said = served.end()
    assert code == 0
    assert "Rejected 4 messages" in said
    assert "Recordings: none." in said
