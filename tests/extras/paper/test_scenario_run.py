"""One scenario of the evaluation: a whole folder or none, and runs that repeat themselves."""

from pathlib import Path

import pytest
from refusals import refused

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.paper.contact_table import ContactRow
from soft_gripper.extras.paper.forces import ContactForceRow
from soft_gripper.extras.paper.scenario_run import evaluated_scenario, is_finished, run_scenario
from soft_gripper.files.row_table import read_csv
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

pytestmark = pytest.mark.slow

FILES = {
    "scenario.yaml",
    "recording.nc",
    "metrics.csv",
    "forces.csv",
    "contact.csv",
    "contact_forces.csv",
    "animation.html",
}


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_run_leaves_a_whole_folder(short, folder):
    assert set(contents(folder)) >= FILES
    assert [path.name for path in folder.parent.iterdir()] == ["short"]
    assert is_finished(folder, evaluated_scenario(short))
    assert Recording.load(folder / "recording.nc")["time"].values[-1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("file", "row", "number", "columns"),
    [
        (
            "metrics.csv",
            PoseRow,
            6 * 2 * 4 * 2,
            "estimator,nominal,sections,pressure_kpa,bend_angle_deg,pose_error_mm,tip_error_mm,sideways_angle_deg,twist_angle_deg",
        ),
        (
            "forces.csv",
            ForceRow,
            2 * 2 * 4 * 2 * 12,
            "estimator,nominal,sections,pressure_kpa,joint,estimated_nm,true_nm",
        ),
        ("contact.csv", ContactRow, 2 * 2, "pressure_kpa,touching_links,contact_length_mm,sign_changes"),
        (
            "contact_forces.csv",
            ContactForceRow,
            2 * 3 * 2,
            "estimator,nominal,sections,pressure_kpa,borders,estimated_n,true_n,total_n,normal_n,estimated_mm,true_mm",
        ),
    ],
)
def test_tables_of_a_run(folder, file, row, number, columns):
    assert (folder / file).read_text().splitlines()[0] == f"scenario,finger,{columns}"
    rows = read_csv(folder / file, row)
    assert len(rows) == number
    assert {getattr(row, "sections", 1) for row in rows} <= {1, 2, 3, 4}


@pytest.mark.parametrize("before", [True, False], ids=["over an old run", "in an empty place"])
def test_a_run_that_fails_in_the_middle_leaves_what_was_there(short, tmp_path, before, monkeypatch):
    def fail(*_):
        raise MemoryError

    folder = tmp_path / "results" / "short"
    if before:
        folder.mkdir(parents=True)
        (folder / "metrics.csv").write_text("of an old run")
    else:
        folder.parent.mkdir()
    old = contents(folder.parent)
    monkeypatch.setattr("soft_gripper.extras.paper.scenario_run.run_station", fail)
    with pytest.raises(MemoryError):
        run_scenario(short, folder)
    assert contents(folder.parent) == old
    assert [path.name for path in folder.parent.iterdir()] == ["short"] * before


def test_sections_that_do_not_divide_the_segments_are_refused(short, tmp_path):
    (tmp_path / "ten.yaml").write_text(dump_scenario(load_scenario(short, ["models.1.segments=10"])))
    with refused("sections", 3):
        run_scenario(str(tmp_path / "ten.yaml"), tmp_path / "ten")
