"""Mistakes are found before any work."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras.placement.samples import Assumptions
from soft_gripper.extras.placement.tables import check_contacts, check_runs
from soft_gripper.extras.studies.contacts.contacts import Contacts, read_finger
from soft_gripper.scenario.scenario_file import load_scenario

NOTHING = Contacts(read_finger(), *(np.zeros(0) for _ in range(9)))


def run(name, *fingers):
    """What is looked at of a run."""
    return SimpleNamespace(scenario=load_scenario(name), fingers=[SimpleNamespace(finger=f) for f in fingers])


@pytest.mark.parametrize(
    ("name", "field"), [("pick_and_place_box", "task"), ("tip_distance_steps", "control.set_points")]
)
def test_runs_without_steps_of_pressure_are_refused(shipped_finger, name, field):
    with refused(field, "given"):
        check_runs(2, {name: run(name, shipped_finger)})


def test_all_fingers_have_as_many_segments(shipped_finger):
    other = replace(shipped_finger, segments=10)
    one = run("free_bending", shipped_finger)
    check_runs(2, {"one": one}, [shipped_finger])
    for runs, others in (({"one": one, "two": run("free_bending", other)}, []), ({"one": one}, [other])):
        with refused("segments", [10, 12]):
            check_runs(2, runs, others)


@pytest.mark.parametrize("count", [0, 13])
def test_a_finger_has_no_such_count(shipped_finger, count):
    with refused("count"):
        check_runs(count, {"one": run("free_bending", shipped_finger)})


def test_contacts_take_an_estimator_of_contact():
    check_contacts(NOTHING, Assumptions("contact"))
    for estimator in ("arcs", "spline", "gaussian"):
        with refused("--estimator"):
            check_contacts(NOTHING, Assumptions(estimator))
