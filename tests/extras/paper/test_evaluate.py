"""The evaluation: whole folders or none, what is left to do, runs that repeat themselves, and Ctrl-C."""

import shutil
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pytest
import xarray as xr
from here_executor import HereExecutor
from matplotlib.figure import Figure
from refusals import refused

from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.paper.contact_table import ContactRow
from soft_gripper.extras.paper.evaluate import (
    CAPTIONS,
    CONTACT,
    FREE,
    RUNS,
    SCENARIOS,
    TASK,
    run_scenarios,
    summarize,
    unfinished,
)
from soft_gripper.extras.paper.forces import ContactForceRow
from soft_gripper.extras.paper.pose_rows import estimator_rows
from soft_gripper.extras.paper.scenario_run import evaluated_scenario, is_finished
from soft_gripper.files.output import atomic_folder
from soft_gripper.files.row_table import read_csv, write_csv
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.steps import PhaseRow
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario


def test_unfinished_are_those_without_a_whole_folder_of_the_same_scenario(tmp_path):
    assert unfinished(tmp_path) == list(RUNS)
    for name, gravity in ((RUNS[0], [0.0, 0.0, -9.81]), (RUNS[1], [0.0, 0.0, 0.0]), (RUNS[2], [0.0, 0.0, -9.81])):
        with atomic_folder(tmp_path / name) as partial:
            (partial / "scenario.yaml").write_text(dump_scenario(replace(evaluated_scenario(name), gravity=gravity)))
    assert unfinished(tmp_path) == [RUNS[1], *RUNS[3:]]


@pytest.mark.parametrize("harm", ["missing", "truncated", "emptied", "other"])
def test_a_run_whose_results_were_harmed_is_unfinished(tmp_path, harm):
    with atomic_folder(tmp_path / FREE) as partial:
        (partial / "scenario.yaml").write_text(dump_scenario(evaluated_scenario(FREE)))
        (partial / "metrics.csv").write_text("a,b\n1,2\n")
    assert FREE not in unfinished(tmp_path)
    results = tmp_path / FREE / "metrics.csv"
    if harm == "missing":
        results.unlink()
    else:
        results.write_text({"truncated": "a,b\n1", "emptied": "", "other": "a,b\n1,3\n"}[harm])
    assert unfinished(tmp_path) == list(RUNS)


@pytest.mark.slow
def test_one_scenario_that_fails_stops_no_other(short, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bad.yaml").write_text(dump_scenario(load_scenario(short, ["models.0.segments=5"])))
    Path("good.yaml").write_text(dump_scenario(load_scenario(short)))
    advanced = []
    with refused("sections", 2):
        run_scenarios(["bad.yaml", "good.yaml"], tmp_path / "out", HereExecutor(), advanced.append)
    assert is_finished(tmp_path / "out" / "good.yaml", evaluated_scenario("good.yaml"))
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["good.yaml"]
    assert advanced == pytest.approx([0.5, 0.5])


class Summarized(NamedTuple):
    """Rows that differ in every scenario, the figures made from them, and what the figure of the shape was given."""

    poses: list
    forces: list
    figures: dict[str, Figure]
    shapes: list
    out: Path


def pose_rows() -> list[PoseRow]:
    """Errors that differ in everything a row is of; those of a right finger are not to be shown but in free bending."""
    left = [
        PoseRow(scenario, "left", name, "as simulated", n, p, p, part * (1 + i) * p / n, (1 + i) * p / n + 100)
        for name, part in (("arcs", 1.0), ("gaussian", 0.5))
        for i, scenario in enumerate(SCENARIOS)
        for n in (1, 2, 3, 4)
        for p in (10.0, 20.0)
    ]
    wrong = {"finger": "right", "pose_error_mm": 1e3, "tip_error_mm": 1e3}
    return left + [replace(row, **wrong) for row in left if row.scenario != FREE]


def force_rows(poses: list[PoseRow]) -> list[ForceRow]:
    """Of the arcs, at two joints."""
    return [
        ForceRow(row.scenario, row.finger, "arcs", "as simulated", row.sections, row.pressure_kpa, joint, 0.02, 0.03)
        for row in estimator_rows(poses, "arcs")
        for joint in (0, 1)
    ]


def write_scenario(out: Path, ran: Path, name: str, poses: list[PoseRow], forces: list[ForceRow]) -> None:
    """The folder of a scenario, from one that `ran`; only the left finger was pressed, and not in free bending."""
    shutil.copytree(ran, out / name)
    (out / name / "scene.png").touch()
    write_csv(out / name / "metrics.csv", [row for row in poses if row.scenario == name])
    write_csv(out / name / "forces.csv", [row for row in forces if row.scenario == name])
    pressed = [ContactRow(name, "left", p, 1, 10.0, 0) for p in (10.0, 20.0)] if name != FREE else []
    write_csv(out / name / "contact.csv", [*pressed, ContactRow(name, "right", 10.0, 0, 0.0, 0)])
    pressing = [
        ContactForceRow(name, finger, "contact", "as simulated", 4, p, "30 60 90", p / 7, p / 8, 1.0, 1.0, 80.0, 81.0)
        for finger in ("left", "right")
        for p in (10.0, 20.0)
    ]
    write_csv(out / name / "contact_forces.csv", pressing)
    data = Recording.load(out / name / "recording.nc").data.drop_dims("link").assign_attrs(run_of=name)
    forces_of = {f"{finger}.link_contact_force": ("time", i + 0 * data["time"].values) for i, finger in fingers(name)}
    Recording(data.assign(forces_of)).save(out / name / "recording.nc")


def write_task(out: Path) -> None:
    (out / TASK).mkdir()
    write_csv(out / TASK / "phases.csv", [PhaseRow("close", 1.0, 2.0, 3.0, 4.0, 5.0)])
    (out / TASK / "phases.png").touch()
    Recording(xr.Dataset({"task.outcome": ("time", [0.0, float(Outcome.DONE)])})).save(out / TASK / "recording.nc")


@pytest.fixture(scope="module")
def summarized(folder, tmp_path_factory) -> Summarized:
    out, poses = tmp_path_factory.mktemp("summarized"), pose_rows()
    forces = force_rows(poses)
    for name in SCENARIOS:
        write_scenario(out, folder, name, poses, forces)
    write_task(out)
    figures, shapes = {}, []
    where = "soft_gripper.extras.paper.evaluate."
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(where + "save_figure", lambda figure, stem: (figures.update({stem.name: figure}), save(stem)))
        patch.setattr(where + "shape_figure", lambda *given: shapes.append(given))
        patch.setattr(where + "scenes_figure", lambda *_: None)
        found = summarize(out)
    assert (found.outcome, found.phases[0].phase) == (Outcome.DONE.words, "close")
    assert {row.finger for row in (*found.poses, *found.forces)} == {"left"}
    return Summarized(poses, forces, figures, shapes, out)


def fingers(name: str) -> list[tuple[int, str]]:
    """The fingers of a scenario, counted."""
    return list(enumerate(finger.name for finger in make_station(load_scenario(name)).fingers))


def save(stem: Path) -> None:
    """A file in the place of a figure."""
    stem.with_suffix(".svg").touch()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "scenarios", "errors"),
    [
        ("fig5_free_bending", [FREE, FREE], ["pose_error_mm", "tip_error_mm"]),
        ("fig6_pose_error", CONTACT, ["pose_error_mm"] * 4),
        ("fig7_fingertip_error", CONTACT, ["tip_error_mm"] * 4),
    ],
)
def test_figs_5_to_7_show_the_errors_that_they_are_named_after(summarized, name, scenarios, errors):
    for axes, scenario, error in zip(summarized.figures[name].axes, scenarios, errors, strict=True):
        for n in (1, 2, 3, 4):
            (line,) = (line for line in axes.lines if line.get_label() == str(n))
            of_line = (scenario, "left", "arcs", n)
            found = [
                row for row in summarized.poses if (row.scenario, row.finger, row.estimator, row.sections) == of_line
            ]
            expected = [getattr(row, error) for row in found]
            assert list(line.get_ydata()) == pytest.approx(expected)


@pytest.mark.slow
def test_a_summary_leaves_all_rows_and_a_report(summarized):
    poses, forces, figures, _, out = summarized
    read = read_csv(out / "metrics.csv", PoseRow)
    poses, forces = (sorted(rows, key=lambda row: SCENARIOS.index(row.scenario)) for rows in (poses, forces))
    assert [(row.scenario, row.sections) for row in read] == [(row.scenario, row.sections) for row in poses]
    assert [row.tip_error_mm for row in read] == pytest.approx([row.tip_error_mm for row in poses], abs=1e-6)
    assert read_csv(out / "forces.csv", ForceRow) == forces
    assert {row.finger for row in read_csv(out / "contact.csv", ContactRow)} == {"left", "right"}
    assert (out / "report.html").is_file()
    assert set(figures) == {path.stem for path in out.glob("*.svg")} == set(CAPTIONS)
