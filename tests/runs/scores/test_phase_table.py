"""The phases that a task went through: a recording that is made up, against what was put in."""

from types import SimpleNamespace

import numpy as np
import pytest
from pick_and_place import recording
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.control.task import Outcome, Phase
from soft_gripper.runs.scores.steps import outcome, phase_table

STAY = PiecewisePolynomial(np.zeros((6, 1)))
NAMES = ("approach", "close", "lift", "rescue: open", "rescue: home")
PHASES = [Phase(name, STAY, 0.05, i + 1) for i, name in enumerate(NAMES)]
STATION = SimpleNamespace(task=SimpleNamespace(phases=PHASES), fingers=[SimpleNamespace(name="left_finger")])


def recorded(phase, ended=Outcome.DONE):
    """Opening, torque and pressure count the sample, which every 10 ms brings."""
    sample = np.arange(len(phase), dtype=float)
    return recording(
        {
            "task.phase": np.array(phase, dtype=float),
            "task.outcome": np.where(sample < len(phase) - 1, Outcome.RUNNING, ended).astype(float),
            "grip.opening": 1e-3 * sample,
            "grip.torque": -2e-3 * sample,
            "left_finger.sampled_pressure": 4e3 * sample,
        }
    )


def values(row):
    return [row.began_s, row.lasted_s, row.opening_mm, row.torque_mnm, row.pressure_kpa]


def test_a_row_for_every_phase_with_what_was_read_at_its_end():
    rows = phase_table(STATION, recorded([0, 0, 0, 1, 1, 2, 2, 2, 2, 5, 5]))
    assert [row.phase for row in rows] == ["approach", "close", "lift"]
    expected = [[0.0, 0.03, 3, -6, 12], [0.03, 0.02, 5, -10, 20], [0.05, 0.04, 9, -18, 36]]
    np.testing.assert_allclose([values(row) for row in rows], expected, atol=1e-12)


@pytest.mark.parametrize("ended", Outcome)
def test_outcome_is_that_at_the_end(ended):
    found = outcome(recorded([0, 1, 2, 5], ended))
    assert isinstance(found, Outcome)
    assert found == ended
