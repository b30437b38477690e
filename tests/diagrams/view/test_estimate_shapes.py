"""Points of an estimated curve."""

import numpy as np
import pytest

from soft_gripper.diagrams.view.estimate_visualizer import point_at
from soft_gripper.estimators.arcs import join_arcs

ARCS = join_arcs(np.array([0.4, -0.3, 0.0]), np.array([0.03, 0.05, 0.04]))


def test_arcs_begin_and_end_at_their_arc_lengths() -> None:
    ends = ARCS.length.cumsum()
    for begin, end, start, length in zip(ARCS.start, ARCS.end, ends - ARCS.length, ARCS.length, strict=True):
        assert point_at(ARCS, start)[0] == pytest.approx(complex(begin))
        assert point_at(ARCS, start + length)[0] == pytest.approx(complex(end))


def test_between_them_the_heading_turns_evenly() -> None:
    for s, heading in ((0.0, 0.0), (0.015, 0.2), (0.03, 0.4), (0.055, 0.25), (0.1, 0.1)):
        assert point_at(ARCS, s)[1] == pytest.approx(heading)


def test_the_point_moves_along_the_heading() -> None:
    for s in (0.01, 0.05, 0.1):
        moved = (point_at(ARCS, s + 1e-6)[0] - point_at(ARCS, s - 1e-6)[0]) / 2e-6
        assert moved == pytest.approx(np.exp(1j * point_at(ARCS, s)[1]), abs=1e-6)
