"""The studies: their commands, and a user's estimator in them."""

import ast
import dataclasses
import re
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.scenario_file import load_scenario
from studies import ROOT
from studies.commands import COMMANDS
from studies.contacts import estimates
from studies.contacts.contacts import Contacts, read_finger
from studies.estimator_setup import EstimatorSetup
from studies.robustness.plants import FINE, FingerAtRest
from studies.robustness.rows import plant_table, robustness_table


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command.name)
def test_the_module_of_a_study_runs_it(command):
    text = Path(find_spec(command.module).origin).read_text(encoding="utf-8")
    assert "run" in [each.name for each in ast.parse(text).body if isinstance(each, ast.FunctionDef)]


def test_every_folder_is_named_in_the_readme():
    folders = {path.parent.name for path in (ROOT / "studies").glob("*/__init__.py")}
    text = (ROOT / "studies" / "README.md").read_text(encoding="utf-8")
    assert [name for name in folders if f"`{name}`" not in text] == []


PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md"), *(ROOT / "studies").glob("*.md")]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_studies_that_a_page_names_are_there(page):
    named = re.findall(r"python -m studies ([a-z][\w-]*)", page.read_text(encoding="utf-8"))
    assert {*named} <= {command.name for command in COMMANDS}


OWN, THEIRS = "own_blocks:contact_again", "contact"
SHORT = ["pressure.steps.all=[0.0, 150e3]", "pressure.settle=0.3", "pressure.hold_samples=20"]


@pytest.fixture(scope="module")
def recorded():
    station = make_station(load_scenario("free_bending", SHORT))
    return station, run_station(station)


def test_robustness(recorded):
    station, recording = recorded
    held = [FingerAtRest(station, recording, station.fingers[0])]
    for rows in (
        robustness_table("free", held, 0.0, 1, [THEIRS, OWN], [(0.0, 0.0)]),
        plant_table(FINE, "free_bending", held, 1, [THEIRS, OWN]),
    ):
        theirs, own = ([row for row in rows if row.estimator == name] for name in (THEIRS, OWN))
        assert [dataclasses.replace(row, estimator=THEIRS) for row in own] == theirs


def test_contact_trials(monkeypatch):
    """Of two fingers that bend freely."""
    finger, pressure = read_finger(), np.array([30e3, 60e3])
    q, ones, none = resting_angles(finger, pressure, np.zeros(2, dtype=complex)), np.ones(2), np.zeros((2, 3))
    contacts = Contacts(finger, q, pressure, none, ones, none, 0 * q, 0.1 * ones, np.array([0.0, np.pi]), 0 * ones)
    monkeypatch.setattr(estimates, "SETUPS", [EstimatorSetup(2), EstimatorSetup(4)])
    estimates.check_estimator(OWN)
    found = list(estimates.contact_estimates(contacts, [THEIRS, OWN]))
    assert [name for name, *_ in found] == [THEIRS, OWN] * 2
    for (*_, theirs), (*_, own) in zip(found[::2], found[1::2], strict=True):
        np.testing.assert_array_equal(own.estimated_force, theirs.estimated_force)


@pytest.mark.parametrize("name", ["gaussian", "recursive"])
def test_an_estimator_that_finds_no_contact_in_a_sample_is_refused(name):
    with pytest.raises(InputError) as error:
        estimates.check_estimator(name)
    assert (error.value.field, error.value.value) == ("--estimator", name)
