"""soft-gripper place-sensors: from tiny scenarios to a placement that a scenario takes, Ctrl-C, what is refused."""

import csv
import os
import signal
import subprocess
import time

import numpy as np
import pytest
import yaml
from command_line import LISTENING, SHORT, soft_gripper

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.extras.studies.contacts.contacts import Contacts, read_finger, save_contacts
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario
from soft_gripper.scenario.shipped import scenario_path

FILES = {"placements.csv", "runs.csv", "left_out.csv", "placement.png", "placement.svg"}
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
    simulated = soft_gripper("place-sensors", "--count", 3, "--scenarios", scenarios, "--out", tmp_path / "a")
    assert (simulated.code, simulated.err) == (0, "")
    read = soft_gripper("place-sensors", "--count", 3, "--out", tmp_path / "b", "--recordings", *recordings)
    assert {path.name for path in (tmp_path / "a").iterdir()} == FILES
    a, b = (rows(tmp_path / folder / "placements.csv") for folder in "ab")
    assert a == b
    assert len({row["borders"] for row in a}) == 55
    errors = [float(row["pose_error_mm"]) for row in a]
    assert errors == sorted(errors)
    assert [row["run"] for row in rows(tmp_path / "b" / "left_out.csv")] == ["free_bending", "obstructed_inside"]
    assert "equal sections" in read.out
    assert "better by [%]" in read.out


@pytest.mark.slow
def test_a_scenario_takes_what_is_printed(tiny, tmp_path):
    file = tiny / "free_bending" / "recording.nc"
    done = soft_gripper("place-sensors", "--count", 2, "--recordings", file, "--out", tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == FILES - {"left_out.csv"}
    snippet = done.out[done.out.index("sensor:") : done.out.index("Written")]
    overrides = [
        f"{part}.{field}={value}" for part, fields in yaml.safe_load(snippet).items() for field, value in fields.items()
    ]
    scenario = load_scenario("free_bending", overrides)
    best = float(rows(tmp_path / "placements.csv")[0]["borders"])
    assert (scenario.sensor.sections, scenario.sensor.borders) == (2, [best])
    assert (scenario.estimator.type, scenario.estimator.uncertainty.bend_per_pressure) == ("gaussian", 0.1)


@pytest.mark.slow
def test_contacts_add_errors_of_force_and_place(tiny, tmp_path):
    q, ones = np.linspace(0.0, 0.05, 3)[:, None] * np.ones(12), np.ones(3)
    gravity, force = np.tile([0.0, 0.0, 9.81], (3, 1)), np.zeros((3, 3))
    contacts = Contacts(read_finger(), q, 1e4 * ones, gravity, ones, force, q, 0.06 * ones, 0 * ones, 0 * ones)
    save_contacts(contacts, tmp_path / "contacts.nc")
    arguments = ["--estimator", "contact", "--contacts", tmp_path / "contacts.nc", "--out", tmp_path / "out"]
    recording = tiny / "free_bending" / "recording.nc"
    done = soft_gripper("place-sensors", "--count", 2, *arguments, "--recordings", recording)
    assert done.code == 0, done.err
    assert "force [N]  place [mm]  missed [%]" in done.out
    assert all(float(row["force_error_n"]) > 0 for row in rows(tmp_path / "out" / "placements.csv"))


@pytest.mark.slow
def test_two_recordings_of_one_name_are_two_runs(tiny, tmp_path):
    copy = tmp_path / "free_bending" / "recording.nc"
    copy.parent.mkdir()
    copy.write_bytes((tiny / "free_bending" / "recording.nc").read_bytes())
    files = [tiny / "free_bending" / "recording.nc", copy]
    soft_gripper("place-sensors", "--count", 1, "--sensors", "ideal", "--out", tmp_path, "--recordings", *files)
    assert {row["run"] for row in rows(tmp_path / "runs.csv")} == set(map(str, files))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "last"), [(("place-sensors", "--count", "4"), "placement"), ((*SPATIAL, "--count", "8"), "design")]
)
def test_ctrl_c_leaves_nothing_half_done(tmp_path, arguments, last):
    command = [*LISTENING, *arguments, "--out", str(tmp_path / "out")]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    ) as process:
        while not (tmp_path / "out").is_dir():
            assert process.poll() is None
        time.sleep(1.0)
        os.killpg(process.pid, signal.SIGINT)
        printed, complaint = process.communicate(timeout=30)
    assert process.returncode == 130
    assert f"nothing is written until the last {last}" in printed
    assert "Traceback" not in complaint
    assert not (tmp_path / "out").exists()


def test_contacts_take_an_estimator_of_contact(tmp_path):
    one, joints, vector = np.full(1, 0.08), np.zeros((1, 12)), np.zeros((1, 3))
    contact = Contacts(read_finger(), joints, one, vector, one, vector, joints, one, one, one)
    save_contacts(contact, tmp_path / "contacts.nc")
    done = soft_gripper("place-sensors", "--count", 2, "--contacts", tmp_path / "contacts.nc")
    assert done.code == 2
    assert "--estimator = 'gaussian': does not estimate contact" in done.err


SPACE_FILES = {
    "designs.csv",
    "best.csv",
    "pareto.png",
    "pareto.svg",
    "strain.yaml",
    "curvature.yaml",
    "orientation.yaml",
}


@pytest.mark.slow
def test_a_finger_in_space_gets_sensors_that_its_scenario_runs_with(tmp_path):
    done = soft_gripper(*SPATIAL, "--count", 2, "--out", tmp_path / "placed")
    assert (done.code, done.err) == (0, "")
    assert {path.name for path in (tmp_path / "placed").iterdir()} == SPACE_FILES
    assert "errors predicted / made in statics" in done.out
    assert [int(row["sensors"]) for row in rows(tmp_path / "placed" / "best.csv")] == [1, 1, 1, 2, 2, 2]
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
        (["--estimator", "contact"], "--estimator = 'contact': in space sensors are placed for gaussian"),
        (["--contacts", "contacts.nc"], "--contacts = 'contacts.nc': are contacts in the plane"),
        (["--scenarios", "turned_box_grasp,box_grasp"], "the fingers differ"),
        (["--scenarios", "turned_box_grasp,tendon_grasp"], "tendon_grasp: left_finger.tendons"),
    ],
)
def test_what_space_does_not_take_is_refused(tmp_path, arguments, says):
    done = soft_gripper(*SPATIAL, "--count", 2, "--out", tmp_path / "out", *arguments)
    assert done.code == 2
    assert says in done.err
    assert not (tmp_path / "out").exists()
