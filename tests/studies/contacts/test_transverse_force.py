"""The force at right angles to the line from the base to the contact is known better than that along the normal."""

import numpy as np
import pytest

from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.force_posterior import DETECTION_PROBABILITY
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.contacts.contacts import read_finger
from studies.contacts.estimates import driving_torque
from studies.contacts.situations import read_pressed
from studies.contacts.statics import rubbing_contacts
from studies.estimator_setup import MODELS, NOMINAL, EstimatorSetup

FRICTION, FAR = 0.6, 0.4  # coefficient; of the length, beyond which contacts count


@pytest.fixture(scope="module")
def contacts():
    """With any friction up to the cone, on both sides."""
    return rubbing_contacts(200, 31, FRICTION, places=(0.3, 1.0))


@pytest.mark.parametrize(
    ("sections", "borders", "noise", "model", "median", "tenth"),
    [
        (2, [1 / 3], 0.0, MODELS[0], 0.01, 0.06),
        (4, None, 0.0, MODELS[0], 0.004, 0.02),
        (4, None, 1.0, MODELS[0], 0.05, 0.2),
        (4, None, 1.0, NOMINAL, 0.06, 0.2),
    ],
)
def test_its_errors_are_small_and_its_interval_is_true(contacts, sections, borders, noise, model, median, tenth):
    """Median and 90th percentile of its relative error; the normal force errs more, and its interval is wider."""
    setup, transverse = EstimatorSetup(sections, noise, model), contacts.transverse_force
    layout = SensorLayout(read_finger(), sections, borders=borders)
    shape = ContactShape(layout, setup.uncertainty)
    readings = read_pressed(layout, contacts.q, setup.errors, np.random.default_rng(1))
    given = readings, driving_torque(layout.finger, layout.deformations, contacts.pressure), contacts.gravity
    contact, known = shape(*given).contact, shape.posterior(*given)
    counted = (contacts.arc_length > FAR * layout.finger.length) & (known.probability > DETECTION_PROBABILITY)
    assert counted.sum() > 140
    error = np.abs(contact.transverse_force / transverse - 1)[counted]
    of_normal = np.abs(np.abs(contact.force) / contacts.normal_force - 1)[counted]
    assert np.median(error) < min(median, 0.8 * np.median(of_normal))
    assert np.percentile(error, 90) < tenth
    least, _, most = known.transverse_force_interval[counted].T
    true = (least <= transverse[counted]) & (transverse[counted] <= most)
    assert true.mean() > 0.93
    normal_width = np.ptp(known.force_interval[counted][:, [0, 2]], axis=-1) / contacts.normal_force[counted]
    assert np.median((most - least) / transverse[counted]) < 0.75 * np.median(normal_width)
    z = (contact.transverse_force - transverse)[counted] / contact.transverse_force_std[counted]
    assert 0.2 < np.sqrt((z**2).mean()) < 1.2
