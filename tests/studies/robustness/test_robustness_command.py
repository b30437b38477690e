"""python -m studies robustness: its jobs, tables, what is left to run, and what it prints and ends with."""

from contextlib import nullcontext
from itertools import product

import pytest
from csv_rows import csv_rows
from here_executor import HereExecutor
from study_line import study_line

from soft_gripper.estimators.named_estimators import SHAPE_FUNCTIONS
from soft_gripper.extras.paper.claims import Claim
from soft_gripper.extras.paper.scenario_run import SCENARIOS, SECTIONS
from studies import ROOT, kept_rows
from studies.robustness import robustness as module
from studies.robustness.robustness import FOLDER, NOISE_JOBS, NOISY, OTHERS, PLANT_JOBS, SUMMARY
from studies.robustness.rows import NOMINAL_ERRORS, PlantRow, RobustnessRow, nominal_name

HOLDS = Claim("ours", "two sensors are within 1 mm", True, "0.52 mm")
FAILS = Claim("ours", "two sensors are better than four", False, "1.04 times")


def coverage_of(estimator):
    return float("nan") if estimator == "arcs" else 0.5


def of_noise(name, noise, out, seeds, estimators):
    each = product(NOMINAL_ERRORS, SECTIONS, estimators)
    sizes = [(error, n, e, NOMINAL_ERRORS.index(error) + 1) for error, n, e in each]
    return [
        RobustnessRow(
            name, e, nominal_name(*error), noise, n, size / n, 2 * size / n, 3.0, coverage_of(e) + size / 10, seeds
        )
        for error, n, e, size in sizes
    ]


def of_plant(plant, name, seeds, estimators):
    return [
        PlantRow(plant, name, e, n, 4.0 / n, 8.0 / n, 9.0, 5.0, coverage_of(e), seeds)
        for n, e in product(SECTIONS, estimators)
    ]


@pytest.fixture
def executor(monkeypatch):
    """Nothing is simulated or read."""
    here = HereExecutor()
    monkeypatch.setattr(kept_rows, "open_executor", lambda *_: nullcontext(here))
    monkeypatch.setattr(module, "noise_rows", of_noise)
    monkeypatch.setattr(module, "plant_rows", of_plant)
    monkeypatch.setattr(module, "is_finished", lambda *_: True)
    monkeypatch.setattr(module, "robustness_claims", lambda rows, plants: [HOLDS])
    return here


def test_tables_have_all_rows_those_of_sensors_by_noise_and_the_summary_the_worst(tmp_path, executor):
    outcome = study_line("robustness", "--out", tmp_path, "--seeds", "7")
    noisy, others, shown = (csv_rows(tmp_path / FOLDER / table) for table in (NOISY, OTHERS, SUMMARY))
    assert len(noisy) == len(SHAPE_FUNCTIONS) * len(SECTIONS) * len(NOMINAL_ERRORS) * len(NOISE_JOBS)
    assert list(dict.fromkeys((row["scenario"], float(row["noise"])) for row in noisy)) == NOISE_JOBS
    assert list(dict.fromkeys((row["plant"], row["scenario"]) for row in others)) == PLANT_JOBS
    assert {row["seeds"] for row in (*noisy, *others)} == {"7"}
    numbers = [[row[name] for name in ("sensors_1", "sensors_2", "sensors_4", "covered_percent_2")] for row in shown]
    keys = "table", "scenario", "estimator"
    published = csv_rows(ROOT / "docs/studies" / SUMMARY)
    assert [[row[key] for key in keys] for row in shown] == [[row[key] for key in keys] for row in published]
    assert [*shown[0]] == [*published[0]]
    assert numbers[0] == ["3.00/6.00", "1.50/3.00", "0.75/1.50", ""]
    assert numbers[3 * len(SCENARIOS)] == ["60-80"] * 3 + [""]
    assert numbers[-1] == ["4.00/8.00", "2.00/4.00", "1.00/2.00", "50"]
    assert (tmp_path / FOLDER / "robustness.png").stat().st_size > 10_000
    assert "3.00/6.00" in outcome.out


@pytest.mark.parametrize(("claim", "code"), [(HOLDS, 0), (FAILS, 1)])
def test_a_claim_that_fails_is_printed_and_ends_with_1(claim, code, tmp_path, executor, monkeypatch):
    monkeypatch.setattr(module, "robustness_claims", lambda rows, plants: [claim])
    outcome = study_line("robustness", "--out", tmp_path)
    assert outcome.code == code
    assert claim.text in outcome.out
