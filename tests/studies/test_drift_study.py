"""An hour of drift: what zeroing is worth in a synthetic series, and the study's table, figure and claims."""

from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from here_executor import HereExecutor
from loaded_fingers import Push, in_balance
from printed_numbers import table_problems
from study_line import study_line

from soft_gripper.files.row_table import read_csv
from studies import kept_rows
from studies.contacts.contacts import read_finger
from studies.drift import drift as study
from studies.drift.drift import FIGURE, SUMMARY, TABLE
from studies.drift.grasps import Grasps
from studies.drift.hour import (
    MINUTES,
    POLICIES,
    DriftRow,
    PolicyRow,
    held_rows,
    policy_rows,
    simulate_hour,
)

HELD, OPEN, PRESSURE = 80, 40, 90e3  # samples of a grasp; Pa


def still_grasp(force: float) -> Grasps:
    """Held for 8 s by a force across the finger near the tip, open for 4 s, without any motion; by statics."""
    finger, down = read_finger(), 9.81 + 0j
    held = in_balance(finger, PRESSURE, down, [Push(0.1, force)])
    free = in_balance(finger, 0.0, down, [])
    q = np.repeat([held, free], [HELD, OPEN], axis=0)
    directions = np.exp(1j * np.append(0, np.cumsum(held)))
    place = np.sum(np.diff(np.minimum(finger.link_ends, 0.1)) * directions)  # z + i x, m
    link = np.searchsorted(finger.joint_arc_lengths, 0.1)
    transverse = force * np.real(np.conj(place) * directions[link]) / np.abs(place)
    pressure, forces = np.repeat([PRESSURE, 0.0], [HELD, OPEN]), np.repeat([transverse, 0.0], [HELD, OPEN])
    return Grasps(q, pressure, np.tile([0.0, 0.0, 9.81], (len(q), 1)), forces)


@pytest.fixture(scope="module")
def rows() -> dict[str, DriftRow]:
    """Minutes 6 to 10, under the policies of `contact`."""
    hour = simulate_hour([still_grasp(0.4), still_grasp(0.8)], 1, minutes=10, sensors=8)
    samples = held_rows(hour.truth, (10,))
    estimates = {name: POLICIES[name](hour, samples) for name in ("never", "in free motion")}
    return {name: next(policy_rows(0, name, hour, samples, found)) for name, found in estimates.items()}


def test_zeroing_in_free_motion_removes_what_has_drifted(rows):
    free, drifted = rows["in free motion"], rows["never"]
    assert free.tip_mm < 0.5 * drifted.tip_mm
    assert free.force_width_n < drifted.force_width_n
    assert free.samples == 25 * 8, "a sample of every grasp of five minutes"


def test_bands_hold_under_either_policy(rows):
    for row in rows.values():
        assert row.shape_covered_percent >= 90
        assert row.force_covered_percent >= 90
        assert row.force_stated_percent == 100
        assert 0.4 < row.force_rms_z < 1.3


def row(part: int, policy: str, minute: int, **changes: float) -> DriftRow:
    like = DriftRow(part, policy, minute, 0.5, 1.0 + part, 0.8 + part, 95.0, 0.1, 0.5, 94.0, 1.0, 100.0, 100)
    return replace(like, **changes)


@pytest.fixture
def rows_of_part(monkeypatch):
    """Parts at once, in this process; what is appended to the list is asked for."""
    made: list[tuple[int, int]] = []

    def rows(part: int, seed: int) -> list[DriftRow]:
        made.append((part, seed))
        return [row(part, policy, minute) for policy in POLICIES for minute in MINUTES]

    monkeypatch.setattr(study, "drift_rows", rows)
    monkeypatch.setattr(kept_rows, "open_executor", lambda *_: nullcontext(HereExecutor()))
    return made


def test_the_study_is_resumed(tmp_path, rows_of_part):
    arguments = "drift", "--parts", "2", "--seed", "7", "--out", tmp_path
    study_line(*arguments)
    assert sorted(rows_of_part) == [(0, 7), (1, 7)]
    table, written = (tmp_path / TABLE).read_text(), (tmp_path / SUMMARY).read_text()
    (tmp_path / TABLE).write_text("".join(table.splitlines(keepends=True)[:-3]))
    study_line(*arguments, "--resume")
    assert rows_of_part[2:] == [(1, 7)]
    assert ((tmp_path / TABLE).read_text(), (tmp_path / SUMMARY).read_text()) == (table, written)
    assert len(written.splitlines()) == 1 + len(POLICIES) * len(MINUTES)
    assert (tmp_path / f"{FIGURE}.png").stat().st_size > 10_000


PAGE = Path(__file__).parents[2] / "docs" / "studies" / "drift.md"
SHOWN = [("never", 5), *((policy, minute) for policy in POLICIES for minute in (30, 60))]


@pytest.mark.published
def test_the_page_shows_what_the_command_writes(tmp_path):
    """Minutes of two hours, with its defaults."""
    study_line("drift", "--out", tmp_path)
    rows, page = read_csv(tmp_path / SUMMARY, PolicyRow), PAGE.read_text(encoding="utf-8")
    found = {(row.policy, row.minute): row for row in rows}
    shown = [found[each] for each in SHOWN]
    of_shape = [[row.minute, row.tip_mm, row.tip_percent, row.shape_covered_percent] for row in shown]
    of_force = [[row.force_error_n, row.force_width_n, row.force_covered_percent, row.force_rms_z] for row in shown]
    results = [[*shape, *force] for shape, force in zip(of_shape, of_force, strict=True)]
    assert table_problems(page, "policy | minute | tip [mm]", results) == []
