"""Force and place of single contacts as an estimator finds them under a case."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from soft_gripper.diagrams.schema.scenario import SensorConfig, StrainErrorsConfig
from soft_gripper.diagrams.schema.sensor_presets import strain_errors
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.evaluation.contact_sensors import LAYOUTS
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.evaluation.contacts.trial_cases import CALIBRATIONS, CASES, ESTIMATORS, Case
from soft_gripper.evaluation.contacts.trial_readings import Readings, disturbed_readings, ideal_readings
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ContactForce
from soft_gripper.shape.uncertainty import Uncertainty

SEEDS = 20  # sets of sensors with errors


@dataclass(frozen=True)
class ContactEstimate:
    """What an estimator makes of M contacts, read by E sets of sensors."""

    estimator: str
    layout: SensorLayout  # as simulated
    case: Case
    contact: ContactForce  # each (E, M)


def contact_estimates(contacts: Contacts) -> Iterator[ContactEstimate]:
    """Of every estimator, under every layout of sensors and every case."""
    for sections, borders in LAYOUTS:
        layout = SensorLayout(contacts.finger, sections, borders=borders)
        unlike = {(case.preset, case.averaged): case for case in CASES}
        read = {sensors: _read(layout, contacts, case) for sensors, case in unlike.items()}
        for case in CASES:
            readings = read[case.preset, case.averaged]
            for name in ESTIMATORS:
                yield ContactEstimate(name, layout, case, estimate_contacts(name, layout, case, readings, contacts))


def estimate_contacts(
    estimator: str, layout: SensorLayout, case: Case, readings: Readings, contacts: Contacts
) -> ContactForce:
    """What an estimator of contact finds, each (E, M).

    Args:
        estimator: of ESTIMATORS.
        layout: as simulated.
        case: what is believed of the finger, and how it is calibrated.
        readings: by E sets of sensors.
        contacts: of them pressure and gravity are used.
    """
    believed = SensorLayout(case.believed_finger(layout.finger), layout.sections, borders=layout.borders)
    scale, shape = CALIBRATIONS[case.calibration](believed, readings.free), readings.pressed.shape[:-1]
    pressure, gravity = (
        np.broadcast_to(factor * known, shape)
        for factor, known in ((scale.pressure, contacts.pressure), (scale.gravity, contacts.gravity))
    )
    function = SHAPE_FUNCTIONS[estimator](believed, Uncertainty(reading=case.reading))
    found = function(readings.pressed, believed.finger.pressure_torque(pressure), gravity).contact
    assert found is not None
    return found._replace(force=scale.force * found.force, force_std=scale.force * found.force_std)


def _read(layout: SensorLayout, contacts: Contacts, case: Case) -> Readings:
    if case.preset is None:
        return ideal_readings(layout, contacts)
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=case.preset)))
    assert errors is not None
    return disturbed_readings(layout, contacts, errors, SEEDS, case.averaged)
