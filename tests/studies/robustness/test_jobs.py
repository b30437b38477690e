"""Jobs on robustness: their rows, in order and of this study alone, and what is left to run."""

from itertools import product

import pytest
from csv_rows import csv_rows
from here_executor import HereExecutor
from refusals import refused

from soft_gripper.extras.paper.scenario_run import SCENARIOS, SECTIONS
from studies.robustness import jobs as module
from studies.robustness.jobs import FOLDER, NOISE_JOBS, PLANT_JOBS, run_robustness
from studies.robustness.rows import NOMINAL_ERRORS, PlantRow, RobustnessRow

NUMBERS = 1.0, 2.0, 3.0
NOISY, PLANTS = "robustness.csv", "plants.csv"


def of_noise(name, fingers, noise, seeds, estimators):
    assert [recording for _, recording in fingers] == [f"recording of {name}"]
    each = product(NOMINAL_ERRORS, SECTIONS, estimators)
    return [RobustnessRow(name, e, error.name, noise, n, *NUMBERS, float("nan"), seeds) for error, n, e in each]


def of_plant(plant, name, fingers, seeds, estimators):
    return [PlantRow(plant.name, name, e, n, *NUMBERS, 4.0, 0.5, seeds) for n, e in product(SECTIONS, estimators)]


@pytest.fixture(autouse=True)
def _quick(monkeypatch):
    """Nothing is simulated or read."""
    monkeypatch.setattr(module.Recording, "load", lambda path: f"recording of {path.parent.name}")
    monkeypatch.setattr(module, "make_private_station", lambda scenario: scenario)
    monkeypatch.setattr(module, "run_station", lambda station, described: None)
    monkeypatch.setattr(module, "touched_fingers", lambda name, station, recording: [(station, recording)])
    monkeypatch.setattr(module, "robustness_table", of_noise)
    monkeypatch.setattr(module, "plant_table", of_plant)


def ran(out, seeds=20, estimators=("arcs",), executor=None, resume=False):
    reported = []
    found = run_robustness(out, seeds, estimators, executor or HereExecutor(), reported.append, resume)
    assert sorted(map(str, reported)) == sorted(map(str, [*NOISE_JOBS, *PLANT_JOBS]))
    return found


def test_the_tables_have_all_rows_those_of_sensors_by_noise(tmp_path):
    rows, plants = ran(tmp_path, 7, ["arcs", "mine:make"])
    assert [row.noise for row in rows] == sorted(row.noise for row in rows)
    assert len(rows) == 2 * len(SECTIONS) * len(NOMINAL_ERRORS) * len(NOISE_JOBS)
    assert len(plants) == 2 * len(SECTIONS) * len(PLANT_JOBS)
    for table, found in ((NOISY, rows), (PLANTS, plants)):
        written = csv_rows(tmp_path / FOLDER / table)
        assert [row["scenario"] for row in written] == [row.scenario for row in found]
        assert {row["seeds"] for row in written} == {"7"}
    assert list(dict.fromkeys((row.plant, row.scenario) for row in plants)) == PLANT_JOBS
    assert [row.scenario for row in rows[:: len(rows) // len(NOISE_JOBS)]] == [*SCENARIOS] * 4


def test_jobs_whose_rows_are_damaged_are_run_again(tmp_path):
    ran(tmp_path)
    whole = {table: (tmp_path / FOLDER / table).read_bytes() for table in (NOISY, PLANTS)}
    (tmp_path / FOLDER / NOISY).write_bytes(whole[NOISY].replace(b"2.000000", b"2.100000", 1))
    (tmp_path / FOLDER / PLANTS).write_bytes(whole[PLANTS][:-5])
    executor = HereExecutor()
    ran(tmp_path, executor=executor, resume=True)
    assert [call[:2] for call in executor.calls] == [NOISE_JOBS[0], PLANT_JOBS[-1]]
    assert {table: (tmp_path / FOLDER / table).read_bytes() for table in whole} == whole


def test_other_seeds_and_estimators_are_another_study(tmp_path):
    ran(tmp_path)
    for other in ({"seeds": 5}, {"estimators": ["arcs", "mine:make"]}):
        with refused("--resume"):
            ran(tmp_path, resume=True, **other)


def test_a_job_that_fails_ends_the_study_after_the_others(tmp_path, monkeypatch):
    def fail(name, fingers, noise, seeds, estimators):
        if (name, noise) == NOISE_JOBS[0]:
            raise RuntimeError
        return of_noise(name, fingers, noise, seeds, estimators)

    monkeypatch.setattr(module, "robustness_table", fail)
    with pytest.raises(RuntimeError):
        ran(tmp_path)
    assert len(csv_rows(tmp_path / FOLDER / NOISY)) == len(SECTIONS) * len(NOMINAL_ERRORS) * (len(NOISE_JOBS) - 1)
