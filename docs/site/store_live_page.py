"""Stores a picture of the live page: `PYTHONPATH=tests/helpers python docs/site/store_live_page.py [FILE]`.

Simulated hardware, a process of its own, closes on a box in real time, with its force limited. The picture is taken
once both fingers have been in contact for a while. It needs chromium and chromedriver.
"""

import re
import signal
import subprocess
import sys
import time
from dataclasses import asdict
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from browser import open_url

from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.hardware.bench_schema import bench_from_inputs
from soft_gripper.scenario.scenario_file import load_scenario

HARDWARE = Path(__file__).parents[2] / "examples" / "bench" / "simulated_hardware.py"
SCENARIO, CHANGES = (
    "box_grasp",
    (
        *("sensor.sections=2", "sensor.errors.preset=realistic", "sensor.period=0.05", "estimator.type=recursive"),
        *("control.set_points=[0.06, 0.01]", "control.hold=8", "control.force_limit=0.65"),
        *("control.force_gains={kp: 2.0e4, ki: 2.0e5}", "control.gains={kp: 1.0e5, ki: 3.0e6, kd: 17}"),
    ),
)
SOURCE, SINK, STALE_AFTER = "udp://127.0.0.1:5005", "udp://127.0.0.1:5006", 0.5  # s: this machine may be busy
WINDOW, MOST = "1500,950", 100.0  # pixels, and s to wait for that
HELD = 4.0  # s of contact


def main(file: Path) -> None:
    """Writes the picture."""
    config = bench_from_inputs(Bench(load_scenario(SCENARIO, CHANGES)).inputs, SOURCE)
    config.sink, config.stale_after = SINK, STALE_AFTER
    scenario = [SCENARIO, *(part for change in CHANGES for part in ("--set", change))]
    live = [sys.executable, "-c", "from soft_gripper.commands import main; main()", "live", *scenario, "--page"]
    with TemporaryDirectory() as folder:
        bench = Path(folder) / "bench.yaml"
        bench.write_text(yaml.dump(asdict(config)))
        process = subprocess.Popen([*live, "--bench", bench], stderr=subprocess.PIPE, text=True)
        assert process.stderr is not None
        found = (re.search(r"http://\S+", line) for line in process.stderr)
        address = next(filter(None, found))[0]
        driver = open_url(address, Path(folder) / "profile", WINDOW)
        gripper = subprocess.Popen([sys.executable, HARDWARE, *scenario])
        began = held = time.monotonic()
        while time.monotonic() < min(held + HELD, began + MOST):
            if driver.find_element("id", "tables").text.count("touched here") < 2:
                held = time.monotonic()
            time.sleep(0.1)
        file.write_bytes(driver.get_screenshot_as_png())
        driver.quit()
        gripper.terminate()
        process.send_signal(signal.SIGINT)
        print(process.stderr.read())


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "docs/extras/bench/live_page.png"))
