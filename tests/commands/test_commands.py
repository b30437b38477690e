"""The commands list, show, expand and run: what they print and which files they write."""

import csv
import shutil
import xml.etree.ElementTree as ET
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from command_line import short, soft_gripper
from matplotlib.figure import Figure

from soft_gripper.diagrams.recording import Recording
from soft_gripper.models import DIRECTORY
from soft_gripper.pictures import phases
from soft_gripper.runs.scores.steps import StepRow
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import SHIPPED, scenario_names

FINGER = DIRECTORY / "grippers" / "finger.urdf"
COLUMNS = "scenario,finger,estimator,nominal,sections,pressure_kpa,bend_angle_deg,pose_error_mm,tip_error_mm"
COLUMNS += ",sideways_angle_deg,twist_angle_deg"
pytestmark = pytest.mark.usefixtures("empty_folder")


@pytest.fixture
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def files() -> list[str]:
    """All files below the working folder."""
    return sorted(str(path) for path in Path().rglob("*") if path.is_file())


def table(path: str | Path) -> list[dict[str, str]]:
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def test_list_names_every_scenario_with_its_description() -> None:
    lines = soft_gripper("list").out.splitlines()
    shipped = scenario_names()
    assert {path.stem for path in SHIPPED.glob("*.yaml")} <= set(shipped)
    assert [line.split()[0] for line in lines] == shipped
    for line, name in zip(lines, shipped, strict=True):
        assert load_scenario(name).description
        assert line.endswith(load_scenario(name).description)


@pytest.mark.parametrize("ending", ["dot", "svg"])
def test_show_draws_the_blocks(ending: str) -> None:
    assert soft_gripper("show", "free_bending", "--graphviz", f"blocks.{ending}").code == 0
    drawing = Path(f"blocks.{ending}").read_text()
    if ending == "svg":
        assert ET.fromstring(drawing).tag.endswith("svg")
    of_a_finger = ("pressure_drive", "sensors", "estimation", "scoring")
    for block in ("plant", "logs", "pressure_steps", *(f"left_finger.{name}" for name in of_a_finger)):
        assert block in drawing
    assert files() == [f"blocks.{ending}"]


def test_expand_prints_what_pydrake_alone_loads(load_plant) -> None:
    text = soft_gripper("expand", FINGER).out
    assert not list(ET.fromstring(text).iter("finger"))
    assert "soft_gripper" not in text
    assert load_plant(text, base="mount").num_positions() == 12


def test_expand_takes_another_number_of_segments_for_every_finger(load_plant) -> None:
    two_fingers = "package://soft_gripper/grippers/two_finger.urdf"
    text = soft_gripper("expand", two_fingers, "--segments", 7).out
    assert load_plant(text, base="palm").num_positions() == 2 * 7


def test_run_writes_scenario_recording_and_tables() -> None:
    run = soft_gripper("run", "free_bending", *short())
    assert run.code == 0
    folder = "results/free_bending"
    tables = [f"{table}.csv" for table in ("forces", "metrics")]
    assert files() == [f"{folder}/{name}" for name in (*tables, "recording.nc", "scenario.yaml", "success.csv")]
    assert folder in run.out
    assert soft_gripper("show", f"{folder}/scenario.yaml").out == Path(f"{folder}/scenario.yaml").read_text()
    recording = Recording.load(f"{folder}/recording.nc")
    assert recording["left_finger.pressure"].attrs["units"] == "Pa"
    assert recording["left_finger.pressure"].values[-1] == pytest.approx(60e3, rel=0.01)


def test_run_of_a_grasp_prints_contact_forces_with_their_band_and_nothing_as_nan() -> None:
    steps = ("--set", "pressure.steps={all: [0.0, 75.0e3]}", "--set", "pressure.settle=0.5")
    out = soft_gripper("run", "box_grasp", *steps, "--set", "pressure.hold_samples=50", "--out", "here").out
    _, title, _, _, left, right = out[out.index("\nTransverse contact forces") :].splitlines()[:6]
    assert title == "Transverse contact forces at 2.00 s, estimated by contact"
    row = table("here/contact_forces.csv")[-1]
    band = f"{float(row['least_n']):.2f} to {float(row['most_n']):.2f}"
    true, estimated = (float(row[name]) for name in ("true_transverse_n", "transverse_n"))
    numbers = f"{true:.2f} {float(row['true_mm']):.0f} {estimated:.2f}"
    assert right.split() == ["right_finger", *numbers.split(), *band.split(), f"{float(row['estimated_mm']):.0f}"]
    assert left.startswith("left_finger ")
    assert "\nWidth: 44.0 mm; stiffness, estimated: not known\n" in out
    assert "nan" not in out


@pytest.mark.parametrize("free", ["true", "false"])
def test_a_grasped_object_that_is_welded_is_noted(free: str) -> None:
    steps = ("--set", "pressure.steps={all: [0.0, 75.0e3]}", "--set", "pressure.settle=0.5", "--set", "success=[]")
    changes = ("--set", f"models.box.free={free}", "--set", "pressure.hold_samples=10")
    said = soft_gripper("run", "box_grasp", *steps, *changes, "--out", "here")
    note = "models.table.free or models.box.free = False: the fingers hold it, but only a free model has a grasp"
    assert (note in said.err) == (free == "false") == (not Path("here/grasps.csv").exists())


def test_run_of_a_task_records_the_forces_of_its_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []
    monkeypatch.setattr(phases, "phases_figure", lambda *given: drawn.append(given[-1]) or Figure())
    soft_gripper("run", "bottle_grasp", "--set", "task.time_limit=0.3", "--out", "here")
    rows, (forces,) = table("here/contact_forces_over_time.csv"), drawn
    assert [float(row["time_s"]) for row in rows[::2]] == pytest.approx(forces.data["time"].values)
    assert [row["finger"] for row in rows[:2]] == ["left_finger", "right_finger"]
    for name in ("true_transverse", "transverse", "least", "most", "true_normal", "normal"):
        column = f"{name}_n"
        np.testing.assert_allclose([float(row[column]) for row in rows], forces.data[name].values.ravel(), atol=1e-6)
    assert float(rows[-1]["least_n"]) < float(rows[-1]["true_transverse_n"]) < float(rows[-1]["most_n"])


@pytest.mark.slow
def test_run_repeats_itself_from_the_scenario_that_it_wrote() -> None:
    soft_gripper("run", "free_bending", *short("gravity=[0, 0, 0]"), "--out", "first")
    assert soft_gripper("run", "first/scenario.yaml", "--out", "second").code == 0
    first, second = (Recording.load(f"{folder}/recording.nc") for folder in ("first", "second"))
    assert first.data.identical(second.data)


def test_run_finds_models_beside_the_scenario_file() -> None:
    Path("mine").mkdir()
    shutil.copy(FINGER, "mine/own.urdf")
    Path("mine/own.yaml").write_text("models: [{name: only, file: own.urdf}]")
    assert soft_gripper("run", "mine/own.yaml", *short()).code == 0
    assert {row["finger"] for row in table("results/own/metrics.csv")} == {"only"}
    assert soft_gripper("run", "results/own/scenario.yaml", "--out", "again").code == 0


def test_run_writes_the_table_of_steps(tmp_path):
    columns = "step,from_mm,to_mm,overshoot_percent,crossings,settling_s,steady_error_estimated_mm,steady_error_true_mm"
    steps = ("--set", "control.set_points=[0.08, 0.06]", "--set", "control.hold=1")
    outcome = soft_gripper("run", "tip_distance_steps", *steps, "--out", tmp_path)
    assert outcome.code == 0
    assert ",".join(field.name for field in fields(StepRow)) == columns
    with open(tmp_path / "steps.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert ",".join(rows[0]) == columns
    assert [float(row["to_mm"]) for row in rows] == pytest.approx([80, 60])
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "recording.nc",
        "scenario.yaml",
        "steps.csv",
        "success.csv",
    ]
