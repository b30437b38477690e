"""soft-gripper recognition: from a handful of grasps to the model, Ctrl-C, and what it refuses."""

import csv
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from command_line import LISTENING, soft_gripper
from refusals import refusal

from soft_gripper.extras.recognition.object_classifier import load_object_classifier
from soft_gripper.extras.recognition.random_grasps import SHAPES
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

FILES = {
    "grasps.csv",
    "recognition.png",
    "recognition.svg",
    "objects_2_sections.json",
    "objects_4_sections.json",
}


@pytest.mark.slow
def test_a_handful_of_grasps_leads_to_models_a_table_and_a_figure(tmp_path):
    done = soft_gripper("recognition", "--train", 2, "--test", 1, "--jobs", 2, "--out", tmp_path)
    assert done.code == 0
    assert {path.name for path in tmp_path.iterdir()} == FILES
    for sections in (2, 4):
        model = load_object_classifier(tmp_path / f"objects_{sections}_sections.json")
        assert (model.shapes, model.sections, list(model.pressures)) == (
            tuple(SHAPES),
            sections,
            [75e3, 112.5e3, 150e3],
        )
    with (tmp_path / "grasps.csv").open(newline="") as table:
        rows = list(csv.DictReader(table))
    assert [row["set"] for row in rows] == 8 * ["train"] + 4 * ["test"]
    assert not [row["cause"] for row in rows if row["cause"]]
    for sections in (2, 4):
        answers = [(row["shape"], row[f"recognized_{sections}"].split()) for row in rows if row["set"] == "test"]
        right = sum(found.count(shape) / len(found) for shape, found in answers)
        assert f"{sections} sections: {right:.4g} of 4 right ({25 * right:.1f} %)" in done.out
        assert f"{sections} sections, unknown to a model that was trained without the shape: sphere" in done.out


@pytest.mark.slow
def test_ctrl_c_leaves_nothing_half_done(tmp_path):
    command = [*LISTENING, "recognition", "--jobs", "1", "--out", str(tmp_path / "out")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        while not (tmp_path / "out").is_dir():
            assert process.poll() is None
        time.sleep(2.0)  # until it waits for grasps, the first of which takes as long
        os.killpg(process.pid, signal.SIGINT)
        printed, complaint = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "of 440 grasps ended; nothing is written until the last" in printed
    assert "Traceback" not in complaint
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ("models.2.free=false", "models = []: give one free model"),
        ("models.2.file=package://soft_gripper/objects/box.sdf", "box.sdf"),
        ("sensor.type=my_sensors:make", "sensor.type = 'my_sensors:make': give strain"),
        ("estimator.type=my_estimators:make", "estimator.type = 'my_estimators:make': give arcs"),
        ("pressure.steps.all=[75e3, 75e3]", "each at another pressure"),
        ("pressure.steps.all=[0, 75e3]", "above 0 Pa"),
        (
            "models.0={name: one, file: package://soft_gripper/grippers/finger.urdf, X_PC: {translation: [1, 0, 0]}}",
            "two fingers",
        ),
    ],
)
def test_a_scenario_that_does_not_fit_is_refused(change, complaint, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text(dump_scenario(load_scenario("probing_grasp", [change]), tmp_path))
    line = refusal("recognition", "mine.yaml", "--out", "out")
    assert "mine.yaml: " in line
    assert complaint in line
