"""Jobs on robustness: what they leave, whole or not at all, and what is left to run."""

import pytest
from here_executor import HereExecutor

from soft_gripper.extras.studies.robustness import jobs as module
from soft_gripper.extras.studies.robustness.jobs import (
    FOLDER,
    NOISE_JOBS,
    PLANT_JOBS,
    TABLE,
    gather,
    run_robustness,
    unfinished,
)
from soft_gripper.extras.studies.robustness.rows import PlantRow, RobustnessRow
from soft_gripper.files.output import SUMS, atomic_folder
from soft_gripper.files.row_table import read_csv, write_csv

ALL = [*NOISE_JOBS, *PLANT_JOBS]
NOISY, RUBBER = "free_bending/noise_2", "rubber/box_grasp"


def row_of(job, seeds, estimator="arcs"):
    if job in PLANT_JOBS:
        return PlantRow(*PLANT_JOBS[job], estimator, 1, 1.0, 2.0, 3.0, 4.0, 0.5, seeds)
    scenario, noise = NOISE_JOBS[job]
    return RobustnessRow(scenario, estimator, "as simulated", noise, 1, 1.0, 2.0, 3.0, float("nan"), seeds)


def write(out, jobs, seeds=20) -> None:
    for job in jobs:
        with atomic_folder(out / FOLDER / job) as partial:
            write_csv(partial / TABLE, [row_of(job, seeds)])


def test_jobs_without_whole_rows_of_as_many_seeds_and_these_estimators_are_unfinished(tmp_path) -> None:
    assert unfinished(tmp_path, 20, ["arcs"]) == ALL
    write(tmp_path, ALL)
    assert unfinished(tmp_path, 20, ["arcs"]) == []
    assert unfinished(tmp_path, 5, ["arcs"]) == unfinished(tmp_path, 20, ["arcs", "mine:make"]) == ALL
    for job, harm in ((ALL[1], ("2.000000", "2.100000")), (ALL[-1], ("\n", ""))):
        file = tmp_path / FOLDER / job / TABLE
        file.write_text(file.read_text().replace(*harm))
    assert unfinished(tmp_path, 20, ["arcs"]) == [ALL[1], ALL[-1]]


def test_all_rows_are_gathered_those_of_sensors_by_noise(tmp_path) -> None:
    write(tmp_path, ALL)
    rows = gather(tmp_path, NOISE_JOBS, RobustnessRow, "robustness.csv")
    assert [row.noise for row in rows] == sorted(noise for _, noise in NOISE_JOBS.values())
    again = read_csv(tmp_path / FOLDER / "robustness.csv", RobustnessRow)
    assert [(row.scenario, row.noise) for row in again] == [(row.scenario, row.noise) for row in rows]
    assert gather(tmp_path, PLANT_JOBS, PlantRow, "plants.csv") == [row_of(job, 20) for job in PLANT_JOBS]


@pytest.fixture
def quick(held, monkeypatch, tmp_path):
    """Nothing is simulated, and there is a recording in the place of that of free bending."""
    (tmp_path / "free_bending").mkdir()
    held.recording.save(tmp_path / "free_bending" / "recording.nc")
    monkeypatch.setattr(module, "run_station", lambda station: held.recording)
    monkeypatch.setattr(module, "touched_fingers", lambda name, station, recording: [(held, recording)])


@pytest.mark.slow
def test_jobs_leave_their_rows_and_a_plant_its_models_and_recording(quick, held, tmp_path, monkeypatch) -> None:
    def of_noise(name, fingers, noise, seeds, estimators):
        ((_, recording),) = fingers
        assert len(recording["time"]) == len(held.recording["time"])
        return [row_of(f"{name}/noise_{noise:g}", seeds, *estimators)]

    monkeypatch.setattr(module, "robustness_table", of_noise)
    monkeypatch.setattr(
        module,
        "plant_table",
        lambda plant, name, fingers, seeds, estimators: [row_of(f"{plant.name}/{name}", seeds, *estimators)],
    )
    advanced = []
    run_robustness([NOISY, RUBBER], tmp_path, 7, ["mine:make"], HereExecutor(), lambda: advanced.append(1))
    assert len(advanced) == 2
    for job, kind, files in (
        (NOISY, RobustnessRow, {TABLE, SUMS}),
        (RUBBER, PlantRow, {"two_finger.urdf", "recording.nc", TABLE, SUMS}),
    ):
        folder = tmp_path / FOLDER / job
        assert {path.name for path in folder.iterdir()} == files
        (row,) = read_csv(folder / TABLE, kind)
        assert (row.scenario, row.estimator, row.seeds) == (
            job.partition("/")[0 if job == NOISY else 2],
            "mine:make",
            7,
        )
    assert set(ALL) - set(unfinished(tmp_path, 7, ["mine:make"])) == {NOISY, RUBBER}


def test_a_job_that_fails_leaves_nothing(quick, tmp_path, monkeypatch) -> None:
    def fail(*_):
        raise RuntimeError

    monkeypatch.setattr(module, "plant_table", fail)
    with pytest.raises(RuntimeError):
        run_robustness([RUBBER], tmp_path, 3, ["arcs"], HereExecutor(), lambda: None)
    assert [path.name for path in tmp_path.iterdir()] == ["free_bending"]
