"""Runs of other plants: what they leave, whole or not at all, and what is left to run."""

import pytest
from here_executor import HereExecutor

from soft_gripper.evaluation.robustness import plant_runs
from soft_gripper.evaluation.robustness.plant_runs import (
    RUNS,
    TABLE,
    gather_plants,
    run_folder,
    run_plants,
    unfinished_runs,
)
from soft_gripper.evaluation.robustness.plant_table import PlantRow
from soft_gripper.evaluation.robustness.plants import RUBBER
from soft_gripper.files.csv_table import read_csv, write_csv
from soft_gripper.files.output import SUMS, atomic_folder


def row(run, seeds=20) -> PlantRow:
    return PlantRow(*run, "arcs", 1, 1.0, 2.0, 3.0, 4.0, 0.5, seeds)


def test_runs_without_rows_of_as_many_seeds_are_unfinished_and_all_are_gathered(tmp_path) -> None:
    assert unfinished_runs(tmp_path, 20) == list(RUNS)
    for run in RUNS:
        with atomic_folder(run_folder(tmp_path, run)) as partial:
            write_csv(partial / TABLE, [row(run)])
    assert unfinished_runs(tmp_path, 20) == []
    assert unfinished_runs(tmp_path, 5) == list(RUNS)
    assert gather_plants(tmp_path) == [row(run) for run in RUNS]
    (run_folder(tmp_path, RUNS[0]) / TABLE).write_text("")
    assert unfinished_runs(tmp_path, 20) == [RUNS[0]]


@pytest.fixture
def quick(held, monkeypatch):
    """Nothing is simulated."""
    monkeypatch.setattr(plant_runs, "run_station", lambda station: held.recording)
    monkeypatch.setattr(plant_runs, "touched_fingers", lambda *_: [held])


def test_a_run_leaves_models_recording_and_rows(quick, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(plant_runs, "plant_table", lambda plant, name, fingers, seeds: [row((plant.name, name), seeds)])
    run_plants([(RUBBER.name, "box_grasp")], tmp_path, 3, HereExecutor(), lambda: None)
    folder = run_folder(tmp_path, (RUBBER.name, "box_grasp"))
    assert {path.name for path in folder.iterdir()} == {"two_finger.urdf", "recording.nc", TABLE, SUMS}
    assert read_csv(folder / TABLE, PlantRow) == [row((RUBBER.name, "box_grasp"), 3)]


def test_a_run_that_fails_leaves_nothing(quick, tmp_path, monkeypatch) -> None:
    def fail(*_):
        raise RuntimeError

    monkeypatch.setattr(plant_runs, "plant_table", fail)
    with pytest.raises(RuntimeError):
        run_plants([(RUBBER.name, "box_grasp")], tmp_path, 3, HereExecutor(), lambda: None)
    assert not run_folder(tmp_path, (RUBBER.name, "box_grasp")).exists()
    assert list(tmp_path.iterdir()) == []
