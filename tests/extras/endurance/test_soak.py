"""Runs for as long as SOAK says, s (`make soak`): the memory of no process grows, or by what is named."""

import os
import subprocess
import sys
import time
from importlib.metadata import version

import numpy as np
import pytest
from command_line import short
from processes import family

from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.sweep import run_sweep
from soft_gripper.scenario.scenario_file import read_override

pytestmark = pytest.mark.slow

SOAK = float(os.environ.get("SOAK", "5"))
SETTLED = 25  # runs
RAMP = 100  # runs of one process, in which its heap grows to what it then uses again
FIXED = dict(map(read_override, short("pressure.settle=0.1")[1::2]))
MODULUS = "models.0.fingers.all.youngs_modulus"
FREES = tuple(map(int, version("drake").split(".")[:2])) >= (1, 58)  # diagrams with blocks in Python
MOST_A_STATION = 10  # MB that a station keeps elsewhere, see docs/sweeps.md
# Prints MB after every run: of the same scenario, with another seed each time, or with another finger each time.
SIMULATE = """
import sys, time
from soft_gripper import changed_scenario, simulate

key, began, i = sys.argv[1], time.monotonic(), 0
short = {"pressure.steps": {"all": [1e4]}, "pressure.settle": 0.1, "pressure.hold_samples": 1}
while time.monotonic() - began < float(sys.argv[2]) or i < int(sys.argv[3]):
    simulate(changed_scenario("free_bending", {**short, key: 250000 + i}))
    i += 1
    print(int(open("/proc/self/statm").read().split()[1]) * 4096 / 1e6, flush=True)
"""


def test_memory_does_not_grow(tmp_path):
    """Every fourth run of other fingers, for which a station is built."""
    sizes = []

    def sweep(runs: int, name: str) -> float:
        varied = [{"sensor.seed": i, MODULUS: 2.5e5 + i // 4} for i in range(runs)]
        began = time.monotonic()
        run_sweep("free_bending", varied, tmp_path / name, executor, fixed=FIXED, report=report)
        return (time.monotonic() - began) / runs

    def report(fine: bool) -> None:
        assert fine
        sizes.append(max(one.resident() for one in family(os.getpid())))

    with open_executor(2) as executor:
        lasts = sweep(10, "first")
        sizes.clear()
        sweep(max(2 * SETTLED, int(SOAK / lasts)), "long")
    settled = np.array(sizes[SETTLED:])
    assert settled.max() < 1.2 * settled[0], f"{settled[0]:.0f} MB became {settled.max():.0f}"


@pytest.mark.parametrize("key", ["sensor.seed", pytest.param(MODULUS, marks=pytest.mark.published)])
def test_simulate_in_a_loop(key):
    """Stations of equal scenarios are used again; others are freed, or stay where Drake never frees them."""
    done = subprocess.run(
        [sys.executable, "-c", SIMULATE, key, str(SOAK), str(RAMP + SETTLED)],
        capture_output=True,
        text=True,
        check=True,
    )
    sizes = np.array([*map(float, done.stdout.split())])
    runs, settled = len(sizes), sizes[RAMP]
    growth = (sizes[-1] - settled) / (runs - RAMP)
    assert growth < MOST_A_STATION
    if FREES or key == "sensor.seed":
        assert sizes[-1] < 1.2 * settled, f"{settled:.0f} MB became {sizes[-1]:.0f} in {runs} runs"
