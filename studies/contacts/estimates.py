"""Force and location of single contacts as estimated under a condition: a nominal model and sensors.

A finger bends freely for its calibration, is released, and is pressed. Each posture is held for a fifth of a second, so
that sensors with errors read the contact with the history of a finger in use. Free motion needs no simulation: it is
the balance of `resting_angles`.

E sets of sensors, M contacts, K samples of free motion.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.shape_estimator import straight_shape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.extras.paper.forces import LAYOUTS
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.nominal_model import describe_nominal_model, read_nominal_model
from soft_gripper.scenario.schema import NominalConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors, disturb
from studies.contacts.contacts import Contacts, G, read_finger
from studies.contacts.found_contact import FoundContact, driving_torque
from studies.contacts.self_calibration import CALIBRATIONS, FreeMotion

HELD, PERIOD = 20, 0.01  # samples of every posture, s between them
PRESSURES = np.array([30e3, 60e3, 90e3, 120e3])  # Pa, of the free motion
HANGING = np.array([0.0, 0.0, G])  # m/s^2, gravity in the free motion: the finger hangs
SEEDS = 20  # sets of sensors with errors


class ContactReadings(NamedTuple):
    """Readings of M contacts, by E sets of sensors."""

    free: FreeMotion  # with readings (E, M, K, R)
    pressed: Array  # (E, M, R)


def contact_readings(
    layout: MeasurementModel, contacts: Contacts, errors: StrainErrors | None, seeds: int = 1, averaged: int = 1
) -> ContactReadings:
    """By sensors whose errors, if they have any, are drawn anew for every seed and every contact.

    Each reading is the mean of the last `averaged` samples, up to HELD, of a posture.
    """
    free = resting_angles(layout.finger, PRESSURES, np.full(len(PRESSURES), complex(G)))
    if errors is None:
        pressed = layout.read(contacts.q)
        still = np.broadcast_to(layout.read(free), (1, len(pressed), len(free), layout.readings))
        return ContactReadings(FreeMotion(still, PRESSURES, HANGING), pressed[None])
    straight = np.zeros_like(free[:1])
    way = np.array([np.broadcast_to(q, contacts.q.shape) for q in (straight, *free[:, None], straight, contacts.q)])
    ratios = np.repeat(1 + layout.predict(way), HELD, axis=0)  # (time, contact, reading)
    each = [layout.response.reading(disturb(errors, ratios, PERIOD, np.random.default_rng(i))) for i in range(seeds)]
    held = np.array(each).reshape(seeds, len(way), HELD, *ratios.shape[1:])
    read = held[:, :, -averaged:].mean(axis=2)
    return ContactReadings(FreeMotion(np.moveaxis(read[:, 1:-2], 1, 2), PRESSURES, HANGING), read[:, -1])


REALISTIC = "realistic"
ESTIMATOR = "contact"  # ours; `contact` from a single sample, without earlier ones
SHOWN_LAYOUT = LAYOUTS[1]  # in the figure


def preset_errors(preset: str | None) -> StrainErrors | None:
    """Errors of strain sensors of a preset; None: they are ideal."""
    return None if preset is None else strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=preset)))


@dataclass(frozen=True)
class Condition:
    """The nominal model and the sensors that an estimator has."""

    youngs_modulus: str | None = None  # nominal, as a change; None: as simulated
    calibration: str = "none"  # of CALIBRATIONS
    preset: str | None = None  # errors of the sensors; None: they are ideal
    averaged: int = 1  # samples
    reading: float = Uncertainty.reading  # standard deviation that is assumed of the extension ratios

    @property
    def nominal(self) -> str:
        """The nominal finger in a few words."""
        return describe_nominal_model(self._nominal)

    @property
    def sensors(self) -> str:
        """In one word."""
        return self.preset or "ideal"

    def nominal_finger(self, finger: Finger) -> Finger:
        """The nominal finger."""
        return read_nominal_model(self._nominal).finger(finger)

    @property
    def _nominal(self) -> NominalConfig:
        return NominalConfig({} if self.youngs_modulus is None else {"youngs_modulus": self.youngs_modulus})


# Gain errors and hysteresis of 1 % at strains up to 0.15, and noise of 0.002, together.
_SINGLE, _MEAN = 0.0025, 0.0015
_WRONG = [(change, calibration) for calibration in CALIBRATIONS for change in ("+10 %", "-10 %")]
CONDITIONS = (
    Condition(),
    *(Condition(*wrong) for wrong in _WRONG),
    Condition(preset=REALISTIC, averaged=1, reading=_SINGLE),
    Condition(preset=REALISTIC, averaged=HELD, reading=_MEAN),
    *(Condition(*wrong, REALISTIC, HELD, _MEAN) for wrong in _WRONG),
)
SHOWN_CONDITIONS = (
    CONDITIONS[0],
    Condition("+10 %", "trusting chamber"),
    Condition(preset=REALISTIC, averaged=HELD, reading=_MEAN),
)


@dataclass(frozen=True)
class ContactEstimate:
    """The estimates of one estimator for M contacts, read by E sets of sensors."""

    estimator: str
    layout: SensorLayout  # as simulated
    condition: Condition
    contact: FoundContact  # each (E, M)


def check_estimator(name: str) -> None:
    """Checks an estimator before any work is done.

    Raises:
        InputError: if it does not exist, does not estimate contacts, or needs earlier samples.
    """
    layout = SensorLayout(read_finger(), 1)
    function = estimator_function(name, layout, Uncertainty())
    if isinstance(function, RecursiveShape):
        raise InputError("contacts", "--estimator", name, "needs a recording; contacts are samples by themselves")
    if straight_shape(function, layout).contact is None:
        raise InputError("contacts", "--estimator", name, f"does not estimate contact; {ESTIMATOR} does")


def contact_estimates(contacts: Contacts, estimators: Sequence[str]) -> Iterator[ContactEstimate]:
    """Estimates of every estimator, under every layout of sensors and every condition."""
    for sections, borders in LAYOUTS:
        layout = SensorLayout(contacts.finger, sections, borders=borders)
        sensors = {(condition.preset, condition.averaged) for condition in CONDITIONS}
        read = {each: contact_readings(layout, contacts, preset_errors(each[0]), SEEDS, each[1]) for each in sensors}
        for condition in CONDITIONS:
            readings = read[condition.preset, condition.averaged]
            for name in estimators:
                found = estimate_contacts(name, layout, condition, readings, contacts)
                yield ContactEstimate(name, layout, condition, found)


def estimate_contacts(
    estimator: str, layout: SensorLayout, condition: Condition, readings: ContactReadings, contacts: Contacts
) -> FoundContact:
    """Contacts as estimated, each (E, M).

    Args:
        estimator: its name, see `check_estimator`.
        layout: as simulated.
        condition: the nominal finger, and how it is calibrated.
        readings: by E sets of sensors.
        contacts: of which pressure and gravity are used, and the truth to compare with.
    """
    nominal = replace(layout, finger=condition.nominal_finger(layout.finger))
    scale, shape = CALIBRATIONS[condition.calibration](nominal, readings.free), readings.pressed.shape[:-1]
    pressure = np.broadcast_to(scale.pressure * contacts.pressure, shape)
    gravity = np.broadcast_to(np.asarray(scale.gravity)[..., None] * contacts.gravity, (*shape, 3))
    assumed = Uncertainty(reading=condition.reading, bend_per_pressure=EXACT)
    function = estimator_function(estimator, nominal, assumed)
    contact = function(
        readings.pressed, driving_torque(nominal.finger, nominal.deformations, pressure), gravity
    ).contact
    found = FoundContact.of(contact, contacts, nominal.deformations != ("bending",))
    scaled = {name: scale.force * getattr(found, name) for name in ("force", "force_std", "transverse_force")}
    return replace(found, **scaled)
