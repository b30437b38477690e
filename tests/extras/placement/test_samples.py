"""What is taken of a run: touched fingers, and the last sample of every step."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.estimators.driving_torque import driving_torques
from soft_gripper.extras.hardware.recorded_run import RecordedRun
from soft_gripper.extras.placement.samples import held_fingers, single_contacts
from soft_gripper.extras.studies.contacts.contacts import save_contacts
from soft_gripper.extras.studies.contacts.statics import rubbing_contacts
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig

STEPS = ["pressure.steps.all=[0, 60e3]", "pressure.settle=0.5", "pressure.hold_samples=5"]


@pytest.fixture(scope="module")
def run():
    """Runs a scenario in two short steps."""

    def run_scenario(name):
        station = make_station(load_scenario(name, STEPS))
        return RecordedRun(run_station(station), station.scenario, station.fingers)

    return run_scenario


def test_only_touched_fingers_count(run):
    """The peg is in the way of the left finger."""
    obstructed = run("obstructed_inside")
    (held,) = held_fingers("obstructed_inside", obstructed)
    recorded = obstructed.recording["left_finger.sampled_joint_angles"].values
    np.testing.assert_array_equal(held.way[:, 0], recorded)
    contacts, force = held.contacts, obstructed.recording["left_finger.true_contact_force"].values[held.held]
    np.testing.assert_array_equal(contacts.normal_force, np.abs(force))
    assert held.touched.any()
    pressed = contacts.at(held.touched)
    assert pressed.is_inside.all()
    np.testing.assert_allclose(np.linalg.norm(pressed.force, axis=-1), pressed.normal_force, rtol=0.15)


def test_where_nothing_is_touched_all_count(run):
    free = run("free_bending")
    left, right = held_fingers("free_bending", free)
    np.testing.assert_allclose(free.recording["time"].values[left.held], [0.55, 1.10], atol=1e-9)
    np.testing.assert_allclose(left.pressures[left.held, 0, 0], [0, 60e3], atol=10)
    np.testing.assert_allclose(left.contacts.gravity, [[0, 0, 9.81]] * 2, atol=1e-9)  # it hangs
    assert not left.touched.any()
    np.testing.assert_allclose(left.contacts.q, right.contacts.q, atol=1e-6)
    np.testing.assert_allclose(left.driving(left.finger), left.finger.pressure_torque(left.pressures[left.held, 0, 0]))


def test_driving_torques_remember_creep(run):
    left, _ = held_fingers("free_bending", run("free_bending"))
    creeping = replace(left.finger, creep=(CreepBranch(0.2, 1.0),))
    expected = driving_torques(creeping, left.way[:, 0], left.pressures[:, 0, 0], left.sensor.period)[left.held]
    np.testing.assert_allclose(left.driving(creeping), expected)
    assert np.abs(expected - left.driving(left.finger)).max() > 1e-3


@pytest.mark.slow
def test_a_finger_in_space_has_all_ways_in_which_it_yields(run):
    for name, ways in (("turned_box_grasp", 3), ("three_chambers", 4)):
        for held in held_fingers(name, run(name)):
            assert held.way.shape[-1] == ways * held.finger.segments
            assert held.driving(held.finger).shape == held.contacts.q.shape


def test_single_contacts_are_read_once(tmp_path):
    contacts = rubbing_contacts(5, 0.0, 0.0, 1)
    save_contacts(contacts, tmp_path / "contacts.nc")
    samples = single_contacts(tmp_path / "contacts.nc", SensorConfig())
    assert samples.run == "contacts"
    assert samples.way.shape == (1, len(contacts.q), 12)
    assert samples.touched.all()
    np.testing.assert_allclose(samples.driving(samples.finger), samples.finger.pressure_torque(contacts.pressure))
