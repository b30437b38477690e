"""Commands and the example of grasps: strength, trials, slips."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from pick_and_place import LOOKED_FOR
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix
from refusals import refusal

from slip import creep
from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.grasps.adds import TrialsConfig
from soft_gripper.extras.grasps.commands import grasp_strength as command
from soft_gripper.extras.grasps.strength import LOADS, SLID, StrengthRow
from soft_gripper.extras.grasps.trial import draw, random_numbers
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

FILES = ["strength.csv", "strength.png", "strength.svg"]


def row(load, ended):
    unit = "mN m" if load.is_torque else "N"
    return StrengthRow("torque" if load.is_torque else "force", load.name, 1.25, unit, ended, 2.0, 3.0, 4.0)


@pytest.fixture
def shaken(monkeypatch):
    """What the command asks for, and rows in the place of twelve loads."""
    seen = []

    def strength(scenario, executor, held, shake, report):
        seen.append((held, shake))
        return [row(load, SLID) for load in LOADS]

    monkeypatch.setattr(command, "grasp_strength", strength)
    return seen


def test_tables_and_figure(shaken, tmp_path):
    limits = ["--slid", 2, "--turned", 180, "--seconds", 1, "--jobs", 1]
    done = soft_gripper("grasp-strength", "box_grasp", *limits, "--out", tmp_path, "--json")
    assert done.code == 0
    ((held, shake),) = shaken
    assert held == "box"
    assert (shake.slid, shake.turned, shake.seconds) == pytest.approx((0.002, 3.14159265, 1.0))
    assert sorted(path.name for path in tmp_path.iterdir() if not path.name.startswith(".")) == FILES
    assert [each["direction"] for each in csv_rows(tmp_path / "strength.csv")] == [load.name for load in LOADS]
    assert json.loads(done.out)["strength"][0]["strength"] == 1.25


def test_objects_and_limits_that_do_not_exist(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "--object = 'cup': no such model; known: gripper, table, box" in refusal(
        "grasp-strength", "box_grasp", "--object", "cup"
    )
    assert "free models = 0" in refusal("grasp-strength", "free_bending")
    assert "slid = 0.0" in refusal("grasp-strength", "box_grasp", "--slid", "0")


BOX = (["qw", "qx", "qy", "qz"], ["x", "y", "z"])  # in the state of the plant


@pytest.fixture
def scenario(tmp_path: Path) -> Callable[..., Path]:
    """Writes `pick_and_place_box` with contact looked for, and other changes, to a file."""

    def write(*changes: str, name: str = "box") -> Path:
        path = tmp_path / f"{name}.yaml"
        path.write_text(dump_scenario(load_scenario("pick_and_place_box", [LOOKED_FOR, *changes])))
        return path

    return write


@pytest.mark.slow
def test_a_trial_alone_places_the_box_and_keeps_what_it_takes_to_look_into_it(scenario, tmp_path):
    done = soft_gripper(
        "study", "grasp-trials", "--scenario", scenario(), "--trial", "4", "--seed", "2", "--out", tmp_path
    )
    assert done.code == 0
    printed = {line[:21].strip(): line[21:] for line in done.out.splitlines() if line[20:21] == " "}
    assert (printed["success"], printed["dropped"], printed["cause"]) == ("True", "False", "")
    recording = Recording.load(tmp_path / "box_4" / "recording.nc")
    kept = load_scenario(str(tmp_path / "box_4" / "scenario.yaml"))
    drawn = draw(random_numbers(2, "box", 4), TrialsConfig())
    assert kept.models[3].mass == pytest.approx(1e-3 * drawn.mass_g)
    box = recording["plant.state"].sel(state=["box_box_x", "box_box_y", "box_box_z"]).values
    start = np.array([0.45 + 1e-3 * drawn.x_mm, -0.18 + 1e-3 * drawn.y_mm, 0.03 * drawn.size + 1e-5])
    np.testing.assert_allclose(box[0], start, atol=1e-9)
    error = kept.task.pose_error
    drawn_error = (1e-3 * drawn.error_x_mm, 1e-3 * drawn.error_y_mm, np.radians(drawn.error_yaw_deg))
    assert (error.x, error.y, error.yaw) == pytest.approx(drawn_error)
    assert float(printed["reported_x_mm"]) == pytest.approx(drawn.x_mm + drawn.error_x_mm, abs=1e-3)
    q = recording["plant.state"].sel(state=[f"box_box_{name}" for name in BOX[0]]).values[-1]
    X_WGoal = kept.task.X_WGoal.GetDeterministicValue()
    turned = RotationMatrix(Quaternion(q / np.linalg.norm(q))) @ X_WGoal.rotation().inverse()
    assert float(printed["placed_angle_deg"]) == pytest.approx(np.degrees(abs(turned.ToAngleAxis().angle())), abs=1e-3)
    assert float(printed["placed_error_mm"]) == pytest.approx(
        1e3 * np.linalg.norm(box[-1] - X_WGoal.translation()), abs=1e-3
    )
    forces = [recording[f"{finger}_finger.normal_force"].values for finger in ("left", "right")]
    held = int(np.argmax(recording["task.phase"].values == 3))  # lift
    q, p = (recording["plant.state"].sel(state=[f"box_box_{name}" for name in names]).values[held] for names in BOX)
    X_OW = RigidTransform(Quaternion(q / np.linalg.norm(q)), p).inverse()
    for finger in ("left", "right"):
        x, _, z = X_OW @ recording[f"{finger}_finger.contact_center"].values[held]
        assert abs(x) == pytest.approx(0.022 * drawn.size, abs=2e-4)
        assert abs(z) < 0.03 * drawn.size
    weight = kept.models[3].mass * 9.81
    assert float(printed["peak_force_n"]) == pytest.approx(np.max(forces), abs=1e-3)
    assert np.max(forces) > weight / 2 / kept.models[3].friction


TIME = 0.01 * np.arange(800)  # s


def test_creep_is_the_speed_at_which_a_lifted_object_sinks():
    height = np.interp(TIME, [2.0, 3.0], [0.0, 0.08]) - 1e-4 * np.maximum(TIME - 3.0, 0.0)
    assert creep(TIME, height) == pytest.approx(0.1)


def test_what_stays_behind_has_slipped():
    assert np.isnan(creep(TIME, np.interp(TIME, [2.0, 3.0], [0.0, 0.03])))
