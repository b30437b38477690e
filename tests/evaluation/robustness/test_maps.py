"""Maps, case by case: what is finished is not run again, unless it was for another number of seeds."""

import pytest
from here_executor import HereExecutor

from soft_gripper.evaluation.robustness import maps
from soft_gripper.evaluation.robustness.maps import (
    CASES,
    FOLDER,
    case_file,
    gather_maps,
    run_cases,
    unfinished_cases,
    write_case,
)
from soft_gripper.evaluation.robustness.table import RobustnessRow
from soft_gripper.files.csv_table import read_csv


def write(out, case, seeds=20) -> None:
    row = RobustnessRow(case[0], "arcs", "as simulated", case[1], 1, 1.0, 2.0, 3.0, float("nan"), seeds)
    write_case(case_file(out, case), [row])


def test_cases_without_rows_of_as_many_seeds_are_unfinished(tmp_path) -> None:
    assert unfinished_cases(tmp_path, 20) == list(CASES)
    write(tmp_path, CASES[0])
    write(tmp_path, CASES[1], seeds=5)
    write(tmp_path, CASES[2])
    case_file(tmp_path, CASES[2]).write_text("")
    assert unfinished_cases(tmp_path, 20) == list(CASES[1:])


def test_a_case_whose_number_was_changed_is_unfinished(tmp_path) -> None:
    for case in CASES:
        write(tmp_path, case)
    assert unfinished_cases(tmp_path, 20) == []
    file = case_file(tmp_path, CASES[1])
    file.write_text(file.read_text().replace("2.000000", "2.100000"))
    assert unfinished_cases(tmp_path, 20) == [CASES[1]]


def test_all_rows_are_gathered_by_noise(tmp_path) -> None:
    for case in CASES:
        write(tmp_path, case)
    rows = gather_maps(tmp_path)
    assert [row.noise for row in rows] == sorted(noise for _, noise in CASES)
    again = read_csv(tmp_path / FOLDER / "robustness.csv", RobustnessRow)
    assert [(row.scenario, row.noise) for row in again] == [(row.scenario, row.noise) for row in rows]


def test_cases_leave_the_rows_of_their_recordings(tmp_path, held, monkeypatch) -> None:
    """Of the recording that lies there."""
    folder = tmp_path / "free_bending"
    folder.mkdir()
    held.recording.save(folder / "recording.nc")
    monkeypatch.setattr(maps, "load_scenario", lambda name: held.station.scenario)
    monkeypatch.setattr(
        maps,
        "robustness_table",
        lambda name, fingers, noise, seeds: [
            RobustnessRow(name, fingers[0].finger.name, "", noise, len(fingers), 1.0, 2.0, 3.0, 0.5, seeds)
        ],
    )
    run_cases([("free_bending", 2.0)], tmp_path, 7, HereExecutor(), lambda: None)
    (row,) = read_csv(case_file(tmp_path, ("free_bending", 2.0)), RobustnessRow)
    assert (row.scenario, row.estimator, row.noise, row.sections, row.seeds) == (
        "free_bending",
        held.finger.name,
        2.0,
        2,
        7,
    )


@pytest.mark.parametrize("noise", [0.5, 1.0])
def test_files_are_named_after_the_noise(tmp_path, noise) -> None:
    assert case_file(tmp_path, ("box_grasp", noise)).name == f"noise_{noise:g}.csv"
