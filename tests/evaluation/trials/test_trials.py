"""Many trials: their tables while they run and when they fail, the same whatever the number of processes."""

import csv
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.evaluation.trials import trials
from soft_gripper.evaluation.trials.trial import DetailRow, Trial, TrialRow
from soft_gripper.evaluation.trials.trials import run_trials
from soft_gripper.evaluation.trials.variation import draw, random_numbers

NAMES = ("pick_and_place_irregular", "pick_and_place_box")
COLUMNS = (
    "scenario,trial,success,placed_error_mm,placed_angle_deg,dropped,peak_force_n,"
    "slip_mm,detection_delay_ms,size_error_mm,duration_s,cause"
)


DRAWN = (1.0, 2.0, 3.0, 40.0, 0.6, 1.0, 0.5, -0.5, 0.7, 1.5, 1.5, 3.7)  # what a trial is given


def succeed(file: str, seed: int, trial: int) -> Trial:
    """In the place of a trial that runs."""
    row = TrialRow(file, trial, True, 1.0 + trial, 2.0, False, 2.0, 0.5, 20.0, 1.5, 9.9, "")
    return Trial(row, DetailRow(file, trial, *DRAWN, 0.1, 0.2, 0.3, 0.4))


@pytest.fixture
def batches(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Trials run here, each batch of them backwards; the sizes of the batches."""
    sizes = []

    def call_backwards(work, calls, jobs, ended):
        sizes.append(len(calls))
        for call in reversed(calls):
            future = Future()
            try:
                future.set_result(work(*call))
            except (ArithmeticError, BrokenProcessPool, InputError, SimulationDivergedError) as error:
                future.set_exception(error)
            ended(call, future)

    monkeypatch.setattr(trials, "call_in_processes", call_backwards)
    monkeypatch.setattr(trials, "run_trial", succeed)
    return sizes


def records(folder: Path, table: str = "trials.csv") -> list[dict[str, str]]:
    with (folder / table).open(newline="") as file:
        return list(csv.DictReader(file))


def test_rows_are_in_order_after_every_trial(batches, tmp_path):
    counts = []

    def look(trial: Trial) -> None:
        found = [(record["scenario"], int(record["trial"])) for record in records(tmp_path)]
        assert found == sorted(found, key=lambda key: (NAMES.index(key[0]), key[1]))
        assert (trial.row.scenario, trial.row.trial) in found
        counts.append(len(found))

    run_trials(NAMES, 3, 1, tmp_path, 2, look)
    assert counts == [1, 2, 3, 4, 5, 6]
    assert (tmp_path / "trials.csv").read_text().splitlines()[0] == COLUMNS
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_a_process_makes_way_after_a_number_of_trials(batches, tmp_path, monkeypatch):
    monkeypatch.setattr(trials, "OF_A_WORKER", 3)
    found = run_trials(NAMES, 7, 1, tmp_path, 2, lambda trial: None)
    assert batches == [6, 6, 2]
    assert len(found) == 14


@pytest.mark.parametrize(
    ("error", "cause"),
    [
        (InputError("task.phases[0]", "to", "object", "is out of the arm's reach: 1.2 m"), "out of the arm's reach"),
        (SimulationDivergedError("the simulation diverged before t = 1 s"), "diverged before t = 1 s"),
        (ZeroDivisionError("float\ndivision"), "ZeroDivisionError: float division"),
    ],
)
def test_a_trial_that_fails_leaves_its_cause_and_ends_no_other(batches, tmp_path, monkeypatch, error, cause):
    def fail_once(file: str, seed: int, trial: int) -> Trial:
        if (file, trial) == (NAMES[1], 1):
            raise error
        return succeed(file, seed, trial)

    monkeypatch.setattr(trials, "run_trial", fail_once)
    run_trials(NAMES, 3, 5, tmp_path, 2, lambda trial: None)
    failed = [record for record in records(tmp_path) if record["success"] == "False"]
    assert [(record["scenario"], record["trial"]) for record in failed] == [(NAMES[1], "1")]
    assert cause in failed[0]["cause"]
    assert failed[0]["placed_error_mm"] == failed[0]["duration_s"] == "nan"
    assert len(records(tmp_path)) == 6
    drawn = draw(random_numbers(5, NAMES[1], 1))
    details = records(tmp_path, "trials_details.csv")[4]
    assert float(details["mass_g"]) == pytest.approx(drawn.mass_g, abs=1e-6)
    for part in ("x_mm", "y_mm", "yaw_deg"):
        true, error, reported = (float(details[f"{kind}{part}"]) for kind in ("", "error_", "reported_"))
        assert (true, error) == pytest.approx((getattr(drawn, part), getattr(drawn, f"error_{part}")), abs=1e-6)
        assert reported == pytest.approx(true + error, abs=2e-6)
    assert details["placed_tilt_deg"] == details["placed_x_mm"] == "nan"
    assert (tmp_path / "trials.png").stat().st_size > 10_000


def test_a_trial_that_kills_its_process_takes_no_other_with_it(batches, tmp_path, monkeypatch):
    """The trials that waited for the same processes are run again, each alone."""

    def die(file: str, seed: int, trial: int) -> Trial:
        if trial == 1 or (batches == [4] and trial == 0):
            raise BrokenProcessPool("a process died")
        return succeed(file, seed, trial)

    monkeypatch.setattr(trials, "run_trial", die)
    found = run_trials(NAMES, 2, 1, tmp_path, 2, lambda trial: None)
    assert batches == [4, 1, 1, 1, 1]
    assert [(trial.row.trial, trial.row.success) for trial in found] == 2 * [(0, True), (1, False)]
    assert found[1].row.cause == "BrokenProcessPool: a process died"


def test_what_an_older_run_left_is_gone_before_the_first_trial_ends(batches, tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    run_trials(NAMES, 1, 1, tmp_path, 1, lambda trial: None)
    assert {path.name for path in tmp_path.iterdir()} == {
        "trials.csv",
        "trials_details.csv",
        "trials.png",
        "trials.svg",
    }
    monkeypatch.setattr(trials, "call_in_processes", interrupt)
    with pytest.raises(KeyboardInterrupt):
        run_trials(NAMES, 1, 1, tmp_path, 1, lambda trial: None)
    assert list(tmp_path.iterdir()) == []
