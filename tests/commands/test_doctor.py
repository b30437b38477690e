"""The doctor: finds what works, and what does not."""

import json

import numpy as np
import pytest
from command_line import soft_gripper

from soft_gripper.commands import doctor
from soft_gripper.model_import import mesh_files as mesh_cache


def findings(outcome):
    return {row["part"]: row for row in json.loads(outcome.out)["findings"]}


@pytest.mark.slow
def test_what_works_and_what_is_left_out(monkeypatch):
    monkeypatch.setattr(doctor, "EXTRAS", {"there": "numpy", "missing": "no_such_module"})
    outcome = soft_gripper("doctor", "--json")
    found = findings(outcome)
    assert outcome.code == 0
    assert found["simulation and pictures"]["works"]
    assert found["extra there"]["works"]
    assert found["extra missing"] == {
        "part": "extra missing",
        "works": None,
        "found": "pip install 'soft-gripper[missing]'",
    }


def test_a_picture_of_one_shade_shows_nothing(monkeypatch):
    class Blank:
        def __init__(self, *_, height):
            self.height = height

        def render(self, time):
            return np.full((self.height, self.height, 3), 255, np.uint8)

    monkeypatch.setattr(doctor, "SceneRenderer", Blank)
    outcome = soft_gripper("doctor", "--json")
    assert outcome.code == 1
    drawn = findings(outcome)["simulation and pictures"]
    assert not drawn["works"]
    assert "one shade only" in drawn["found"]


@pytest.mark.slow
def test_what_fails_is_named_and_decides_the_exit_code(monkeypatch, tmp_path):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    outcome = soft_gripper("doctor", "--json")
    assert outcome.code == 1
    broken = findings(outcome)["mesh cache"]
    assert not broken["works"]
    assert str(mesh_cache.cache_folder()) in broken["found"]
