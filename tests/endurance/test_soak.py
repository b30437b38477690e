"""Runs for as long as SOAK says, s (`make soak`): the memory of no process grows."""

import os
import time

import numpy as np
import pytest
from command_line import short
from processes import family

from soft_gripper.diagrams.schema.scenario_file import read_override
from soft_gripper.evaluation.executor.executor import open_executor
from soft_gripper.evaluation.sweep.sweep import run_sweep

pytestmark = pytest.mark.slow

SOAK = float(os.environ.get("SOAK", "20"))
SETTLED = 50  # runs
FIXED = dict(map(read_override, short("pressure.settle=0.1")[1::2]))
MODULUS = "models.0.fingers.all.youngs_modulus"


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
