"""The phases that a task went through are read from its signal."""

import numpy as np
import pytest
import xarray as xr
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.control.task import Phase
from soft_gripper.diagrams.executed_phases import phase_spans
from soft_gripper.diagrams.recording import Recording

STAY = PiecewisePolynomial(np.zeros((6, 1)))
PHASES = [Phase(name, STAY, 0.05, i + 1) for i, name in enumerate(("approach", "close", "lift", "rescue"))]


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ([0, 0, 1, 2, 2, 2, 4, 4], [("approach", 0.0, 1.0), ("close", 1.0, 1.5), ("lift", 1.5, 3.0)]),
        ([0, 1, 3, 3, 4], [("approach", 0.0, 0.5), ("close", 0.5, 1.0), ("rescue", 1.0, 2.0)]),
        ([0, 0, 1, 1], [("approach", 0.0, 1.0), ("close", 1.0, 1.5)]),
        ([0, 0, 0], [("approach", 0.0, 1.0)]),
        ([0, 0, 1], [("approach", 0.0, 1.0)]),
    ],
    ids=["done", "rescued", "out of time", "only one", "ends as one begins"],
)
def test_spans(numbers: list[int], expected: list[tuple[str, float, float]]) -> None:
    data = xr.Dataset({"task.phase": ("time", np.array(numbers, dtype=float))})
    recording = Recording(data.assign_coords(time=0.5 * np.arange(len(numbers))))
    spans = phase_spans(recording, PHASES)
    assert [(span.phase.name, span.begin, span.end) for span in spans] == expected
