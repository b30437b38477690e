"""Runs for as long as SOAK says, s (`make soak`): the memory of no process grows."""

import os
import time

import numpy as np
import pytest
from command_line import short
from processes import family

from soft_gripper.diagrams.schema.scenario_file import read_override
from soft_gripper.evaluation.executor.executor import open_executor
from soft_gripper.evaluation.sweep.axes import Values, points
from soft_gripper.evaluation.sweep.sweep import run_sweep

pytestmark = pytest.mark.slow

SOAK = float(os.environ.get("SOAK", "20"))
ROUND = 20  # runs
FIXED = dict(map(read_override, short("pressure.settle=0.1")[1::2]))


def test_memory_does_not_grow(tmp_path):
    sizes, until = [], time.monotonic() + SOAK
    with open_executor(2) as executor:
        while time.monotonic() < until or len(sizes) < 3:
            seeds = tuple(range(ROUND * len(sizes), ROUND * (len(sizes) + 1)))
            runs = points([Values("sensor.seed", seeds)], "grid")
            table = run_sweep("free_bending", runs, tmp_path / str(len(sizes)), executor, fixed=FIXED)
            assert len(table.rows) == ROUND
            sizes.append(max(one.resident() for one in family(os.getpid())))
    grown = np.array(sizes[1:]) / sizes[1]
    assert grown.max() < 1.2, f"{sizes[1]:.0f} MB became {max(sizes):.0f}"
