"""soft-gripper grasp-strength: tables, figure, exit codes, and what it refuses."""

import json

import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from refusals import refusal

from soft_gripper.extras.grasps.commands import grasp_strength as command
from soft_gripper.extras.grasps.strength import LOADS, SLID, StrengthRow

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
