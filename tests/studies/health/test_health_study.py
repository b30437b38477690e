"""The study of health: a stiffness that is wrong is blamed unless its uncertainty is declared; runs are counted."""

from argparse import Namespace
from contextlib import nullcontext
from dataclasses import replace

import pytest
from here_executor import HereExecutor
from study_line import study_line

from studies import kept_rows
from studies.health import health
from studies.health.health import (
    BELIEF_INTERVAL,
    DECLARED,
    EXACT,
    KINDS,
    Belief,
    HealthRun,
    _calls,
    health_rows,
    run_health,
)


@pytest.mark.slow  # three monitors of a whole run; test_health has the same of the filter alone
def test_a_wrong_stiffness_is_blamed_unless_its_uncertainty_is_declared():
    exact, undeclared, declared = run_health(0, "none", 1, (EXACT, Belief(-0.1, 0.005), Belief(-0.1, 0.1)))
    assert not exact.false_alarm
    assert undeclared.false_alarm
    assert not declared.false_alarm


RUN = HealthRun("exact", 0, "leak", "free_bending", "finger", -1, 3.0, 0.4, True, False, 0.5, "leak")


def test_runs_are_counted_by_belief_and_fault():
    missed, cut = replace(RUN, is_found=False, said="healthy"), replace(RUN, fault="cut", said="held")
    none = replace(RUN, fault="none", is_found=False, false_alarm=True)
    rows = {(row.belief, row.fault): row for row in health_rows([RUN, missed, cut, none, replace(RUN, belief="other")])}
    leaks, every = rows["exact", "leak"], rows["exact", "all"]
    assert (leaks.runs, leaks.found_percent, leaks.right_percent) == (2, 50, 50)
    assert (every.runs, every.right_percent) == (3, pytest.approx(100 / 3))
    assert rows["exact", "none"].false_alarm_percent == 100
    assert rows["other", "all"].right_percent == 100


def test_one_of_some_runs_with_every_fault_is_monitored_with_other_beliefs():
    jobs = list(_calls(Namespace(runs=8 * BELIEF_INTERVAL, seed=1), KINDS, DECLARED))
    chosen = [kind for _, kind, _, beliefs in jobs if len(beliefs) > 1]
    assert sorted(chosen) == sorted(KINDS)
    assert all(beliefs[0] == EXACT for *_, beliefs in jobs)


def test_the_command_writes_and_prints_what_the_runs_say(monkeypatch, tmp_path):
    monkeypatch.setattr(kept_rows, "open_executor", lambda *_: nullcontext(HereExecutor()))
    monkeypatch.setattr(health, "run_health", lambda i, kind, *_: [replace(RUN, fault=kind, is_found=kind != "none")])
    done = study_line("health", "--runs", len(KINDS), "--out", tmp_path)
    assert done.code == 0
    assert [line.split()[-6:] for line in done.out.splitlines() if "leak" in line] == [
        ["1", "100", "100", "0", "0.5", "0.5"]
    ]
    assert {file.name for file in tmp_path.iterdir()} >= {"health.csv", "health_runs.csv", "health.png", "health.svg"}
