"""Many trials: their tables while they run and when they fail, the same whatever the number of processes."""

from dataclasses import fields

import numpy as np
import pytest
from csv_rows import csv_rows
from here_executor import HereExecutor

from soft_gripper.errors import InputError, SimulationDivergedError, WorkerDiedError
from soft_gripper.extras.grasps import trials
from soft_gripper.extras.grasps.adds import TrialsConfig
from soft_gripper.extras.grasps.trial import Details, Trial, draw, random_numbers
from soft_gripper.extras.grasps.trials import run_trials
from soft_gripper.runs.scores.grasp import Grasp
from soft_gripper.runs.scores.recorded_task import Judged

NAMES = ("pick_and_place_irregular", "pick_and_place_box")


DRAWN = (1.0, 2.0, 3.0, 40.0, 0.6, 1.0, 0.5, -0.5, 0.7, 1.5, 1.5, 3.7)  # what a trial is given


def succeed(file: str, seed: int, trial: int) -> Trial:
    """In the place of a trial that runs."""
    result = Judged(True, 1.0 + trial, 2.0, False, 2.0, 0.0, 0.5, 20.0, 1.5, 9.9, "")
    return Trial(
        file, trial, result, Details(*DRAWN, 0.1, 0.2, 0.3, 0.4), Grasp("held", *[1.0] * (len(fields(Grasp)) - 1))
    )


def together(run):
    """Trials that are run together, by a function of one."""

    def work(file, seed, numbers, engine):
        return [run(file, seed, number) for number in numbers]

    return work


@pytest.fixture
def executor(monkeypatch: pytest.MonkeyPatch) -> HereExecutor:
    """Makes trials that succeed."""
    monkeypatch.setattr(trials, "trials_together", together(succeed))
    return HereExecutor()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("error", "cause"),
    [
        (InputError("task.phases[0]", "to", "object", "is out of reach of the arm: 1.2 m"), "out of reach of the arm"),
        (SimulationDivergedError("the simulation diverged before t = 1 s"), "diverged before t = 1 s"),
        (WorkerDiedError("the process died, 2 times"), "the process died, 2 times"),
        (ZeroDivisionError("float\ndivision"), "ZeroDivisionError: float division"),
    ],
)
def test_a_trial_that_fails_leaves_its_cause_and_ends_no_other(executor, tmp_path, monkeypatch, error, cause):
    def fail_once(file: str, seed: int, trial: int) -> Trial:
        if (file, trial) == (NAMES[1], 1):
            raise error
        return succeed(file, seed, trial)

    monkeypatch.setattr(trials, "trials_together", together(fail_once))
    run_trials(NAMES, 3, 5, tmp_path, executor, lambda trial: None)
    failed = [record for record in csv_rows(tmp_path / "trials.csv") if record["success"] == "False"]
    assert [(record["scenario"], record["trial"]) for record in failed] == [(NAMES[1], "1")]
    assert cause in failed[0]["cause"]
    assert failed[0]["placed_error_mm"] == failed[0]["duration_s"] == "nan"
    assert len(csv_rows(tmp_path / "trials.csv")) == 6
    drawn = draw(random_numbers(5, NAMES[1], 1), TrialsConfig())
    details = csv_rows(tmp_path / "trials_details.csv")[4]
    assert float(details["mass_g"]) == pytest.approx(drawn.mass_g, abs=1e-6)
    for part in ("x_mm", "y_mm", "yaw_deg"):
        true, error, reported = (float(details[f"{kind}{part}"]) for kind in ("", "error_", "reported_"))
        assert (true, error) == pytest.approx((getattr(drawn, part), getattr(drawn, f"error_{part}")), abs=1e-6)
        assert reported == pytest.approx(true + error, abs=2e-6)
    assert details["placed_tilt_deg"] == details["placed_x_mm"] == "nan"
    assert (tmp_path / "trials.png").stat().st_size > 10_000


def test_a_trial_without_a_recording():
    found = trials._failed_trial("pick_and_place_box", 1, 3, "no arm is so long")
    assert (found.scenario, found.trial) == ("pick_and_place_box", 3)
    result = found.result
    assert (result.success, result.dropped, result.cause) == (False, False, "no arm is so long")
    assert np.isnan([result.placed_error_mm, result.placed_angle_deg, result.peak_force_n, result.duration_s]).all()
