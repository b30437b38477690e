"""Plants that differ from the nominal finger, and coverage of what is stated of contacts with them."""

from dataclasses import fields

import numpy as np
import pytest

from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.force_posterior import DETECTION_PROBABILITY
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.contacts import model_errors
from studies.contacts.contacts import read_finger
from studies.contacts.estimates import Estimates, driving_torque
from studies.contacts.model_errors import ModelErrorRow, model_error_rows
from studies.contacts.situations import DIFFERENCES, graded_finger
from studies.estimator_setup import NOMINAL, EstimatorSetup

FOUR = EstimatorSetup(4, model=NOMINAL)


def test_a_graded_finger_is_stiffer_at_its_base_and_its_neutral_axis_stays():
    finger, other = read_finger(), graded_finger(0.05)
    along = finger.joint_arc_lengths / finger.length
    np.testing.assert_allclose(other.stiffness / finger.stiffness, 1.05 - 0.1 * along, rtol=1e-12)
    np.testing.assert_allclose(other.section(0.03).neutral_axis, finger.section(0.03).neutral_axis, rtol=1e-9)


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_a_stiffness_that_varies_along_the_finger_is_no_contact_and_intervals_cover_it(noise):
    """By 10 % at both ends; to an estimator that believes in one factor it looks like a contact."""
    setup = EstimatorSetup(4, noise, NOMINAL)
    (row,) = model_error_rows("stiffness -10 % at the base, +10 % at the tip", setup, 60, 1)
    assert row.touched_percent == 0
    assert min(row.interval_percent, row.transverse_percent, row.place_percent) > 93
    assert 0.5 < row.transverse_rms_z < 1.2
    contacts = DIFFERENCES[row.difference].contacts(20, 1, forces=dict.fromkeys(("inner", "outer"), (0.0, 0.0)))
    believing = ContactShape(SensorLayout(read_finger(), 4), Uncertainty(bend_variation=0.0))
    driving = driving_torque(contacts.finger, ("bending",), contacts.pressure)
    known = believing.posterior(believing.layout.read(contacts.q), driving, contacts.gravity)
    assert np.mean(known.probability > DETECTION_PROBABILITY) > 0.5


def test_a_row_counts_what_is_stated(monkeypatch):
    one, nothing = np.ones(4), np.full(4, np.nan)
    low, least = np.array([0.5, 1.5, 0.5, np.nan]), np.array([0.2, 0.4, np.nan, np.nan])
    contacts = Estimates(
        force=one,
        location=0.3 * one,
        estimated_force=one,
        estimated_location=one,
        force_std=one,
        location_std=one,
        degrees=nothing,
        probability=np.array([1.0, 1.0, 1.0, 0.1]),
        interval=np.stack([low, low + 0.5, low + 1], axis=-1),
        bounds=np.ones((4, 3)),
        location_set=np.stack([least, least + 0.2], axis=-1),
        transverse=one,
        estimated_transverse=one + np.array([0.3, -0.4, 0.0, 9.0]),
        transverse_std=one / 2,
        transverse_interval=np.stack([low, low + 0.5, low + 1], axis=-1),
    )
    free = contacts._replace(probability=np.array([1.0, 0.0, 0.0, 0.0]))
    found = [contacts, free]
    monkeypatch.setattr(model_errors, "static_estimates", lambda *given: found.pop(0))
    (row,) = model_error_rows("none", FOUR, 4, 7)
    rms_z = 2 * (0.25 / 3) ** 0.5
    expected = ModelErrorRow("none", 4, "ideal", 4, 200 / 3, 200 / 3, rms_z, 50.0, 75.0, 25.0, 7)
    assert [getattr(row, each.name) for each in fields(row)] == pytest.approx(list(vars(expected).values()))
