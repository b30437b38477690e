"""soft-gripper place-sensors: from tiny scenarios to a placement that a scenario takes, Ctrl-C, what is refused."""

import csv
import math
import os
import signal
import subprocess
import time
from collections import Counter

import pytest
from command_line import LISTENING, SHORT, soft_gripper

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.extras.studies.contacts.contacts import save_contacts
from soft_gripper.extras.studies.contacts.statics import rubbing_contacts
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario
from soft_gripper.scenario.shipped import scenario_path

FILES = {"designs.csv", "made.csv", "placement.png", "placement.svg"}
STEPS = [*SHORT, "pressure.settle=0.4"]


SPATIAL = ["place-sensors", "--scenarios", "turned_box_grasp"]


def rows(path):
    with path.open(newline="") as table:
        return list(csv.DictReader(table))


@pytest.fixture(scope="module")
def tiny(tmp_path_factory):
    """Two scenarios in two short steps, as files, and a recording of each."""
    folder = tmp_path_factory.mktemp("tiny")
    for name in ("free_bending", "obstructed_inside"):
        scenario = load_scenario(name, STEPS)
        (folder / f"{name}.yaml").write_text(dump_scenario(scenario, folder))
        (folder / name).mkdir()
        simulate(scenario).save(folder / name / "recording.nc")
    return folder


@pytest.mark.slow
def test_scenarios_and_their_recordings_lead_to_the_same_placement(tiny, tmp_path):
    scenarios = ",".join(str(tiny / f"{name}.yaml") for name in ("free_bending", "obstructed_inside"))
    recordings = [tiny / name / "recording.nc" for name in ("free_bending", "obstructed_inside")]
    simulated = soft_gripper("place-sensors", "--count", 2, "--scenarios", scenarios, "--out", tmp_path / "a")
    assert simulated.code == 0, simulated.err
    read = soft_gripper("place-sensors", "--count", 2, "--out", tmp_path / "b", "--recordings", *recordings)
    assert {path.name for path in (tmp_path / "a").iterdir()} == {*FILES, "strain.yaml"}
    designs, made = (rows(tmp_path / "b" / file) for file in ("designs.csv", "made.csv"))
    assert rows(tmp_path / "a" / "designs.csv") == designs
    assert [row["pose_mm"] for row in rows(tmp_path / "a" / "made.csv")] == [row["pose_mm"] for row in made]
    assert Counter(row["sensors"] for row in designs) == {"1": 1, "2": 11}
    assert {row["run"] for row in made} == {"free_bending", "obstructed_inside", "mean"}
    assert "equal" in read.out


@pytest.mark.slow
def test_contacts_and_an_estimator_are_chosen(tiny, tmp_path):
    save_contacts(rubbing_contacts(6, 0.2, 0.5, 1), tmp_path / "contacts.nc")
    files = ["--contacts", tmp_path / "contacts.nc", "--recordings", tiny / "free_bending" / "recording.nc"]
    for estimator in ("contact", "arcs"):
        options = "--count", 2, "--estimator", estimator, *files, "--out", tmp_path / estimator
        done = soft_gripper("place-sensors", *options)
        assert done.code == 0, done.err
        forces = {row["run"]: float(row["force_n"]) for row in rows(tmp_path / estimator / "made.csv")}
        assert math.isnan(forces["free_bending"])
        assert math.isnan(forces["contacts"]) == (estimator == "arcs")
    designs = [(tmp_path / estimator / "designs.csv").read_text() for estimator in ("contact", "arcs")]
    assert designs[0] == designs[1], "the ranking is that of the estimators that ship"


@pytest.mark.slow
def test_two_recordings_of_one_name_are_two_runs(tiny, tmp_path):
    copy = tmp_path / "free_bending" / "recording.nc"
    copy.parent.mkdir()
    copy.write_bytes((tiny / "free_bending" / "recording.nc").read_bytes())
    files = [tiny / "free_bending" / "recording.nc", copy]
    soft_gripper("place-sensors", "--count", 1, "--sensors", "ideal", "--out", tmp_path / "out", "--recordings", *files)
    assert {row["run"] for row in rows(tmp_path / "out" / "made.csv")} == {*map(str, files), "mean"}


@pytest.mark.slow
def test_ctrl_c_leaves_nothing_half_done(tmp_path):
    command = [*LISTENING, *SPATIAL, "--count", "8", "--out", str(tmp_path / "out")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        while not (tmp_path / "out").is_dir():
            assert process.poll() is None
        time.sleep(1.0)
        os.killpg(process.pid, signal.SIGINT)
        printed, complaint = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "nothing is written until the last design" in printed
    assert "Traceback" not in complaint
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_finger_in_space_gets_sensors_that_its_scenario_runs_with(tmp_path):
    simulate(load_scenario("turned_box_grasp", STEPS)).save(tmp_path / "recording.nc")
    recorded = "--recordings", tmp_path / "recording.nc"
    done = soft_gripper("place-sensors", "--count", 2, *recorded, "--out", tmp_path / "placed")
    assert done.code == 0, done.err
    assert {path.name for path in (tmp_path / "placed").iterdir()} == {
        *FILES,
        "strain.yaml",
        "curvature.yaml",
        "orientation.yaml",
    }
    assert {row["sensors"] for row in rows(tmp_path / "placed" / "made.csv")} == {"1", "2"}
    for kind in ("strain", "curvature", "orientation"):
        part = (tmp_path / "placed" / f"{kind}.yaml").read_text()
        (tmp_path / "mine.yaml").write_text(scenario_path("turned_box_grasp").read_text() + part)
        sets = [word for step in STEPS for word in ("--set", step)]
        ran = soft_gripper("run", tmp_path / "mine.yaml", "--out", tmp_path / kind, *sets)
        assert ran.code == 0, ran.err
        assert (tmp_path / kind / "recording.nc").exists()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--scenarios", "turned_box_grasp,box_grasp"], "yields"),
    ],
)
def test_what_space_does_not_take_is_refused(tmp_path, arguments, says):
    done = soft_gripper(*SPATIAL, "--count", 2, "--out", tmp_path / "out", *arguments)
    assert done.code == 2
    assert says in done.err
    assert not (tmp_path / "out").exists()
