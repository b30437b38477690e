"""soft-gripper design: from a study to files of the best design, resumed, and what it refuses."""

from pathlib import Path

import pytest
import trimesh
import yaml
from command_line import soft_gripper
from csv_rows import csv_rows
from refusals import refusal

from soft_gripper.extras.sweeps.measured_runs import run_and_measure
from soft_gripper.fingers.urdf import expand_urdf

LENGTH, PRESSURE = "models.gripper.fingers.all.length", "pressure.steps.all.0"
STUDY = {
    "scenario": "bottle_grasp",
    "set": {
        "estimator.type": "arcs",
        "record.truth": "every 20",
        "plant_config.time_step": 0.01,
        "task.phases.close.rest": 1.2,
    },
    "vary": {LENGTH: "0.11..0.13", PRESSURE: "60.0e3..120.0e3"},
    "test_draws": 1,
    "ends": [{"measure": "normal_force_n"}, {"measure": "slip_ratio"}],
    "designs": 3,
    "batch": 3,
}


def written(folder: Path, **changes: object) -> Path:
    file = folder / "study.yaml"
    file.write_text(yaml.safe_dump(STUDY | changes, sort_keys=False))
    return file


@pytest.mark.slow
def test_from_a_study_to_files_of_the_best_design(tmp_path):
    study, out = written(tmp_path), tmp_path / "out"
    done = soft_gripper("design", study, "--jobs", 1, "--out", out)
    assert done.code == 0
    assert "3 designs in" in done.out
    designs, runs = csv_rows(out / "designs.csv"), csv_rows(out / "runs.csv")
    assert [row["design"] for row in designs] == ["0", "1", "2", "3"]
    allowed = [row for row in designs[1:] if row["allowed"] == "True"]
    best = min(allowed, key=lambda row: float(row["normal_force_n"]))
    assert f"by normal_force_n design {best['design']} is best" in done.out

    gripper = expand_urdf(out / "best/gripper.urdf")
    assert [finger.length for finger in gripper.fingers] == pytest.approx([float(best[LENGTH])] * 2, rel=1e-8)
    assert trimesh.load_mesh(out / "best/left_finger_shell.stl").is_watertight
    assert (out / "best/left_finger_section.png").stat().st_size > 10_000

    again = run_and_measure(str(out / "best/scenario.yaml"), {})
    (row,) = (row for row in runs if (row["stage"], row["design"]) == ("search", best["design"]))
    assert again["grasp"] == "held"
    assert again["normal_force_n"] == pytest.approx(float(row["normal_force_n"]), rel=1e-6)

    before = (out / "runs.csv").read_bytes()
    resumed = soft_gripper("design", study, "--jobs", 1, "--out", out, "--resume", "--check", 2)
    assert resumed.code == 0
    assert (out / "runs.csv").read_bytes() == before
    agreed = csv_rows(out / "agreement.csv")
    assert {row["runs"] for row in agreed} == {"2"}
    assert {float(row["largest_difference"]) for row in agreed if row["alike"] == "nan"} == {0.0}


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"ends": [{"measure": "grip"}]}, "ends[0].measure = 'grip': known: normal_force_n"),
        ({"scenario": "free_bending", "set": {}, "vary": {"sensor.sections": "1..4"}}, "has no free object to hold"),
    ],
)
def test_a_wrong_study_is_refused_in_one_line(tmp_path, monkeypatch, changes, says):
    written(tmp_path, **changes)
    monkeypatch.chdir(tmp_path)
    line = refusal("design", "study.yaml", "--out", "out")
    assert "study.yaml" in line
    assert says in line
