"""A picture of the live page: `PYTHONPATH=tests/helpers python benchmarks/live_page.py [FILE]`.

Simulated hardware, a process of its own, closes on a cup in real time, with its force limited. The picture is taken
once both fingers have been in contact for a while. It needs chromium and chromedriver.
"""

import re
import signal
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

from browser import open_url

EXAMPLES = Path(__file__).parents[1] / "examples" / "bench"
SCENARIO = (EXAMPLES / "held_cup.yaml", "--set", "sensor.period=0.02")
WINDOW, MOST = "1500,950", 120.0  # pixels, and s to wait for that
HELD = 4.0  # s of contact


def main(file: Path) -> None:
    """Writes the picture."""
    live = [sys.executable, "-c", "from soft_gripper.commands import main; main()", "live", *SCENARIO, "--page"]
    live += ["--bench", EXAMPLES / "held_cup_bench.yaml"]
    hardware = [sys.executable, EXAMPLES / "simulated_hardware.py", *SCENARIO]
    with subprocess.Popen(live, stderr=subprocess.PIPE, text=True) as process, TemporaryDirectory() as profile:
        assert process.stderr is not None
        found = (re.search(r"http://\S+", line) for line in process.stderr)
        address = next(filter(None, found))[0]
        driver = open_url(address, Path(profile), WINDOW)
        gripper = subprocess.Popen(hardware)
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
