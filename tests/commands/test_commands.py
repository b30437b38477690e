"""The commands list, show, expand and run: what they print and which files they write."""

import csv
import json
import re
import shutil
import xml.etree.ElementTree as ET
from html.parser import HTMLParser
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
from command_line import short, soft_gripper
from matplotlib.figure import Figure

from soft_gripper.commands import console, main
from soft_gripper.diagrams.recording import Recording
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.pictures import phases
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import SHIPPED, scenario_names

FINGER = DIRECTORY / "grippers" / "finger.urdf"
COLUMNS = "scenario,finger,estimator,nominal,sections,pressure_kpa,bend_angle_deg,pose_error_mm,tip_error_mm"
COLUMNS += ",sideways_angle_deg,twist_angle_deg"
FORCE_COLUMNS = "scenario,finger,estimator,nominal,sections,pressure_kpa,joint,estimated_nm,true_nm"
pytestmark = pytest.mark.usefixtures("empty_folder")


@pytest.fixture
def empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.fixture(scope="module")
def ran(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run of free bending with two sensors a side."""
    folder = tmp_path_factory.mktemp("run")
    assert soft_gripper("run", "free_bending", *short(), "--sections", 2, "--out", folder).code == 0
    return folder


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


def test_list_has_a_document_of_the_same() -> None:
    found = json.loads(soft_gripper("list", "--json").out)["scenarios"]
    assert soft_gripper("list").out.splitlines() == [f"{name:<{max(map(len, found))}}  {found[name]}" for name in found]


def test_show_prints_a_scenario_that_loads_again() -> None:
    shown = soft_gripper("show", "free_bending", "--sections", 3, "--set", "pressure.settle=0.7")
    assert shown.code == 0
    Path("resolved.yaml").write_text(shown.out)
    assert soft_gripper("show", "resolved.yaml").out == shown.out
    scenario = load_scenario("resolved.yaml")
    assert (scenario.sensor.sections, scenario.pressure.settle) == (3, 0.7)
    assert scenario.pressure.steps == load_scenario("free_bending").pressure.steps


@pytest.mark.parametrize("ending", ["dot", "svg"])
def test_show_draws_the_blocks(ending: str) -> None:
    assert soft_gripper("show", "free_bending", "--graphviz", f"blocks.{ending}").code == 0
    drawing = Path(f"blocks.{ending}").read_text()
    if ending == "svg":
        assert ET.fromstring(drawing).tag.endswith("svg")
    of_a_finger = ("pressure_drive", "pressure_steps", "sensors", "estimation", "scoring")
    for block in ("plant", "logs", *(f"left_finger.{name}" for name in of_a_finger)):
        assert block in drawing
    assert files() == [f"blocks.{ending}"]


def test_expand_prints_what_pydrake_alone_loads(load_plant) -> None:
    text = soft_gripper("expand", FINGER).out
    assert not list(ET.fromstring(text).iter("finger"))
    assert "soft_gripper" not in text
    assert load_plant(text, base="mount").num_positions() == 12


def test_expand_writes_the_same_to_a_file() -> None:
    printed = soft_gripper("expand", FINGER).out
    written = soft_gripper("expand", FINGER, "-o", "plain.urdf")
    assert (written.code, written.out) == (0, "")
    assert Path("plain.urdf").read_text() == printed
    assert files() == ["plain.urdf"]


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


def test_run_has_a_row_for_every_held_step_of_every_finger(ran: Path) -> None:
    assert (ran / "metrics.csv").read_text().splitlines()[0] == COLUMNS
    assert (ran / "forces.csv").read_text().splitlines()[0] == FORCE_COLUMNS
    rows = table(ran / "metrics.csv")
    assert [(row["finger"], float(row["pressure_kpa"])) for row in rows] == [
        (finger, pressure) for finger in ("left_finger", "right_finger") for pressure in (0.0, 60.0)
    ]
    assert [float(row["bend_angle_deg"]) > 10 for row in rows] == [False, True, False, True]


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
def test_a_wrong_nominal_model_is_named_and_shows_in_the_forces() -> None:
    """A finger whose nominal model is too stiff seems to bend under a load."""
    options = short("pressure.settle=1", "gravity=[0, 0, 0]")
    soft_gripper("run", "free_bending", *options, "--out", "right")
    nominal = soft_gripper(
        "run", "free_bending", *options, "--set", "nominal.finger.youngs_modulus=+10 %", "--out", "wrong"
    )
    assert nominal.code == 0
    for name in ("metrics.csv", "forces.csv"):
        assert {row["nominal"] for row in table(f"right/{name}")} == {"as simulated"}
        assert {row["nominal"] for row in table(f"wrong/{name}")} == {"youngs_modulus +10 %"}
    right, wrong = (
        np.array([float(row["estimated_nm"]) - float(row["true_nm"]) for row in table(f"{folder}/forces.csv")])
        for folder in ("right", "wrong")
    )
    straight, bent = (wrong.reshape(2, 2, 12)[:, step] for step in (0, 1))
    assert np.abs(right).max() < 0.05e-3
    assert np.abs(straight).max() < 0.01e-3
    # A tenth of what bends the base joint, which without weight is the torque of the pressure.
    (finger,) = expand_urdf(FINGER).fingers
    np.testing.assert_allclose(bent[:, 0], 0.1 * 60e3 * finger.pressure_gain[0], rtol=0.02)


def test_run_places_as_many_sensors_as_asked_for(ran: Path) -> None:
    assert Recording.load(ran / "recording.nc")["left_finger.kappa"].sizes["section"] == 2
    assert {row["sections"] for row in table(ran / "metrics.csv")} == {"2"}


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


class Links(HTMLParser):
    """Collects what a page would fetch."""

    def __init__(self, page: str):
        super().__init__()
        self.found: list[str | None] = []
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found += [value for name, value in attrs if name in ("src", "href") and tag != "a"]


@pytest.mark.slow
def test_run_keeps_an_animation_that_needs_nothing_else() -> None:
    assert soft_gripper("run", "free_bending", *short(), "--html", "animations/one.html").code == 0
    page = Path("animations/one.html").read_text()
    assert [link for link in Links(page).found if not (link or "").startswith("data:")] == []
    assert "Meshcat" in page
    assert len(page) > 1e6, "the viewer itself is in the page"
    assert [name for name in files() if name.startswith("animations")] == ["animations/one.html"]


def test_progress_is_lines_in_a_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console, "LINE_PERIOD", 1e-6)
    err = soft_gripper("run", "free_bending", *short()).err
    lines = err.splitlines()
    assert len(lines) > 2
    assert all(re.fullmatch(r"free_bending: \d/\d s simulated \[\d\d:\d\d<.*\]", line) for line in lines), err
    assert soft_gripper("run", "free_bending", *short(), "--quiet").err == ""


def test_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit, match="0"):
        main(["--version"])
    assert capsys.readouterr().out == f"soft-gripper {version('soft-gripper')}\n"


def test_run_records_finite_numbers(ran: Path) -> None:
    for name, signal in Recording.load(ran / "recording.nc").data.items():
        # A straight arc has no centre, and what nothing touches no contact.
        nowhere = (".contact_center", ".true_contact_arc_length", ".true_contact_side", ".true_object_width")
        if not str(name).endswith((".arcs", *nowhere)):
            dynamic = str(name).endswith(("external_torque", "torque_tolerance", "external_torque_error"))
            first = (
                5 if dynamic and ".true_" not in str(name) else 0
            )  # a balance of five samples, of which one is read twice
            assert np.isnan(signal.values[:first]).all(), name
            assert np.isfinite(signal.values[first:]).all(), name
