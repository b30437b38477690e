"""The evaluation: whole folders or none, what is left to do, runs that repeat themselves, and Ctrl-C."""

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest
from command_line import LISTENING

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import dump_scenario, load_scenario
from soft_gripper.errors import InputError
from soft_gripper.evaluation.csv_table import read_csv
from soft_gripper.evaluation.paper.evaluate import SCENARIOS, run_scenarios, unfinished
from soft_gripper.evaluation.paper.force_table import ForceRow
from soft_gripper.evaluation.paper.pose_table import PoseRow
from soft_gripper.evaluation.paper.scenario_run import is_finished, run_scenario

SHORT = ["pressure.steps.all=[0, 60e3]", "pressure.settle=0.2", "pressure.hold_samples=5"]
FILES = {"scenario.yaml", "recording.nc", "metrics.csv", "forces.csv", "replay.html"}
COMMAND = [*LISTENING, "evaluate"]


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> str:
    """A scenario file: free bending in two steps of a quarter of a second."""
    file = tmp_path_factory.mktemp("scenario") / "short.yaml"
    file.write_text(dump_scenario(load_scenario("free_bending", SHORT)))
    return str(file)


@pytest.fixture(scope="module")
def folder(short, tmp_path_factory) -> Path:
    """What a run of it leaves."""
    folder = tmp_path_factory.mktemp("results") / "short"
    run_scenario(short, folder)
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_a_run_leaves_a_whole_folder(short, folder):
    assert set(contents(folder)) >= FILES
    assert [path.name for path in folder.parent.iterdir()] == ["short"]
    assert is_finished(folder, load_scenario(short))
    assert Recording.load(folder / "recording.nc")["time"].values[-1] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("file", "row", "number", "columns"),
    [
        (
            "metrics.csv",
            PoseRow,
            2 * 4 * 2,
            "estimator,belief,sections,pressure_kpa,bend_angle_deg,pose_error_mm,tip_error_mm",
        ),
        ("forces.csv", ForceRow, 2 * 4 * 2 * 12, "estimator,belief,sections,pressure_kpa,joint,estimated_nm,true_nm"),
    ],
)
def test_tables_of_a_run(folder, file, row, number, columns):
    assert (folder / file).read_text().splitlines()[0] == f"scenario,finger,{columns}"
    rows = read_csv(folder / file, row)
    assert len(rows) == number
    assert {row.sections for row in rows} == {1, 2, 3, 4}


def test_a_second_run_leaves_the_same_in_the_place_of_an_old_one(short, folder, tmp_path):
    (tmp_path / "again").mkdir()
    (tmp_path / "again" / "of_an_old_run.csv").touch()
    run_scenario(short, tmp_path / "again")
    first, second = contents(folder), contents(tmp_path / "again")
    assert set(first) == set(second)
    for table in ("metrics.csv", "forces.csv"):
        assert first[table] == second[table]


@pytest.mark.parametrize("before", [True, False], ids=["over an old run", "in an empty place"])
def test_a_run_that_fails_in_the_middle_leaves_what_was_there(short, tmp_path, before):
    def fail(_):
        raise MemoryError

    folder = tmp_path / "results" / "short"
    if before:
        folder.mkdir(parents=True)
        (folder / "metrics.csv").write_text("of an old run")
    else:
        folder.parent.mkdir()
    old = contents(folder.parent)
    with pytest.raises(MemoryError):
        run_scenario(short, folder, progress=fail)
    assert contents(folder.parent) == old
    assert [path.name for path in folder.parent.iterdir()] == ["short"] * before


def test_a_run_that_fails_at_its_tables_leaves_nothing(short, tmp_path, monkeypatch):
    def fail(*_):
        raise MemoryError

    monkeypatch.setattr("soft_gripper.evaluation.paper.scenario_run.force_table", fail)
    with pytest.raises(MemoryError):
        run_scenario(short, tmp_path / "short")
    assert list(tmp_path.iterdir()) == []


def test_another_scenario_is_not_finished(short, folder, tmp_path):
    assert not is_finished(folder, load_scenario(short, ["pressure.settle=0.21"]))
    assert not is_finished(tmp_path / "nothing", load_scenario(short))


def test_sections_that_do_not_divide_the_segments_are_refused(short, tmp_path):
    (tmp_path / "ten.yaml").write_text(dump_scenario(load_scenario(short, ["models.1.segments=10"])))
    with pytest.raises(InputError, match=r"sections = 3: must divide the 10 segments of finger 'right_finger'"):
        run_scenario(str(tmp_path / "ten.yaml"), tmp_path / "ten")


def test_unfinished_are_those_without_a_whole_folder_of_the_same_scenario(tmp_path):
    assert unfinished(tmp_path) == list(SCENARIOS)
    for name in SCENARIOS[:3]:
        (tmp_path / name).mkdir()
        (tmp_path / name / "scenario.yaml").write_text(dump_scenario(load_scenario(name)))
    assert unfinished(tmp_path) == list(SCENARIOS[3:])
    with (tmp_path / SCENARIOS[1] / "scenario.yaml").open("a") as file:
        file.write("gravity: [0, 0, 0]\n")
    assert unfinished(tmp_path) == [SCENARIOS[1], *SCENARIOS[3:]]


def test_one_scenario_that_fails_stops_no_other(short, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bad.yaml").write_text(dump_scenario(load_scenario(short, ["models.0.segments=5"])))
    Path("good.yaml").write_text(dump_scenario(load_scenario(short)))
    advanced = []
    with pytest.raises(InputError, match="must divide the 5 segments"):
        run_scenarios(["bad.yaml", "good.yaml"], tmp_path / "out", 2, advanced.append)
    assert is_finished(tmp_path / "out" / "good.yaml", load_scenario("good.yaml"))
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["good.yaml"]
    assert sum(advanced) == pytest.approx(0.5)


@pytest.mark.parametrize("moment", ["at the beginning", "in the middle"])
def test_interrupted_evaluation_says_what_is_missing(tmp_path, moment):
    """Ctrl-C reaches the whole process group, workers too."""
    out = tmp_path / "evaluation"
    begun = out.exists if moment == "at the beginning" else lambda: list(out.glob(".partial-*"))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([*COMMAND, "--out", out, "--jobs", "1"], start_new_session=True, **pipes) as process:
        while process.poll() is None and not begun():
            time.sleep(0.05)
        time.sleep(0.5)
        os.killpg(process.pid, signal.SIGINT)
        printed, complaint = process.communicate(timeout=30)
    assert process.returncode == 130
    missing = [name for name in SCENARIOS if not (out / name).exists()]
    assert f"Missing: {', '.join(missing)}; " in printed
    assert f"evaluate --out {out} --resume" in printed
    assert "Traceback" not in complaint
    assert sorted(path.name for path in out.iterdir()) == sorted(set(SCENARIOS) - set(missing))
