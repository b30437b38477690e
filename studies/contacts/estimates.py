"""Contacts -> readings -> estimates beside the truth, one way for all contact studies.

In: contacts and the setup of an estimator. Out: `Estimates`, whose errors and coverage the studies put into rows. An
estimator of a new kind needs a case in `compare`, a new setup an entry of SETUPS.

For `contact_readings` a finger bends freely for its calibration, is released, and is pressed. Each posture is held for
a fifth of a second, so that sensors with errors read the contact with the history of a finger in use. Free motion needs
no simulation: it is the balance of `resting_angles`.

E sets of sensors, M contacts, K samples of free motion, R readings; leading axes are free.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.estimators.force_posterior import DETECTION_PROBABILITY
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.shape_estimator import straight_shape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.paper.forces import LAYOUTS
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors, disturb
from studies.contacts.contacts import Contacts, G, read_finger
from studies.contacts.self_calibration import CALIBRATIONS, UNSCALED, FreeMeasurements, Scale
from studies.estimator_setup import MODELS, EstimatorSetup

HELD, PERIOD = 20, 0.01  # samples of every posture, s between them
PRESSURES = np.array([30e3, 60e3, 90e3, 120e3])  # Pa, of the free motion
HANGING = np.array([0.0, 0.0, G])  # m/s^2, gravity in the free motion: the finger hangs
SEEDS = 20  # sets of sensors with errors


class ContactReadings(NamedTuple):
    """Readings of M contacts, by E sets of sensors."""

    free: FreeMeasurements  # with readings (E, M, K, R)
    pressed: Array  # (E, M, R)


def contact_readings(
    layout: MeasurementModel, contacts: Contacts, errors: StrainErrors | None, seeds: int = 1, averaged: int = 1
) -> ContactReadings:
    """Reads contacts by sensors whose errors, if they have any, are drawn anew for every seed and every contact.

    Each reading is the mean of the last `averaged` samples, up to HELD, of a posture.
    """
    q_free = resting_angles(layout.finger, PRESSURES, np.full(len(PRESSURES), complex(G)))
    if errors is None:
        pressed_readings = layout.read(contacts.q)
        still_readings = np.broadcast_to(layout.read(q_free), (1, len(pressed_readings), len(q_free), layout.readings))
        return ContactReadings(FreeMeasurements(still_readings, PRESSURES, HANGING), pressed_readings[None])
    straight = np.zeros_like(q_free[:1])
    postures = [np.broadcast_to(q, contacts.q.shape) for q in (straight, *q_free[:, None], straight, contacts.q)]
    ratios = np.repeat(1 + layout.predict(np.array(postures)), HELD, axis=0)  # (time, contact, reading)
    sets = [disturbed_readings(layout, ratios, errors, PERIOD, np.random.default_rng(seed)) for seed in range(seeds)]
    held_readings = np.array(sets).reshape(seeds, len(postures), HELD, len(contacts.q), layout.readings)
    means = held_readings[:, :, -averaged:].mean(axis=2)
    return ContactReadings(FreeMeasurements(np.moveaxis(means[:, 1:-2], 1, 2), PRESSURES, HANGING), means[:, -1])


def disturbed_readings(
    layout: MeasurementModel, ratios: Array, errors: StrainErrors, period: float, rng: np.random.Generator
) -> Array:
    """Readings of sensors with errors, (T, ..., R), from extension ratios every `period` s."""
    return np.asarray(layout.response.reading(disturb(errors, ratios, period, rng)))


ESTIMATOR = "contact"  # ours; `contact` of a single sample, without earlier ones
_NOTHING = np.empty(0)


class Estimates(NamedTuple):
    """M contacts, true and as estimated by any number of sets of sensors, (..., M); NaN where nothing is estimated.

    Forces are along the normals of the faces that are pressed; of several, the sum. Locations are fractions of the
    length. The posterior, of M contacts, is empty if the estimator has none.
    """

    force: Array  # (M) N, true, absolute
    location: Array  # (M) true
    transverse: Array  # (M) N, true transverse force; of several, taken to press where their centre is
    estimated_force: Array  # N, negative on the opposite face
    force_std: Array  # N
    estimated_location: Array
    location_std: Array
    estimated_transverse: Array  # N
    transverse_std: Array  # N
    degrees: Array  # between the true and the estimated force; NaN for a finger in its plane
    probability: Array = _NOTHING  # (M)
    interval: Array = _NOTHING  # (M, 3) N
    bounds: Array = _NOTHING  # (M, 3) N
    location_set: Array = _NOTHING  # (M, 2)
    transverse_interval: Array = _NOTHING  # (M, 3) N

    @property
    def is_detected(self) -> NDArray[np.bool_]:
        """Contacts that are detected with the probability of DETECTION_PROBABILITY, (M,)."""
        return np.asarray(self.probability > DETECTION_PROBABILITY)

    def subset(self, rows: NDArray[np.bool_]) -> "Estimates":
        """Estimates of the contacts in a mask, (M,), by a single set of sensors."""
        return Estimates(*(values[rows] for values in self))


def joined(parts: Sequence[Estimates]) -> Estimates:
    """Joins the contacts of several estimates."""
    return Estimates(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def compare(contact: ContactForce | None, contacts: Contacts, leaves_plane: bool = False) -> Estimates:
    """Puts estimates of contacts, (..., M), beside the truth.

    Of a finger that leaves its plane the friction is estimated as well: its fraction is taken to be the true one.
    """
    assert contact is not None
    length, no_values = contacts.finger.length, np.full(contact.force.shape, np.nan)
    force = np.where(contacts.is_inside, contact.force, -contact.force)
    std = contact.force_std
    degrees = no_values
    if leaves_plane:
        assert contact.vector is not None
        assert contact.vector_covariance is not None
        size, true = (np.linalg.norm(vector, axis=-1) for vector in (contact.vector, contacts.force))
        cosine = (contacts.force * contact.vector).sum(axis=-1) / (true * size + 1e-30)
        degrees = np.where(size > 0, np.degrees(np.arccos(np.clip(cosine, -1, 1))), np.nan)
        force = size * np.divide(contacts.normal_force, true, out=np.ones(true.shape), where=true > 0)
        std = np.sqrt(np.trace(contact.vector_covariance, axis1=-2, axis2=-1))
    return Estimates(
        force=contacts.normal_force,
        location=contacts.arc_length / length,
        transverse=contacts.transverse_force,
        estimated_force=force,
        force_std=std,
        estimated_location=contact.arc_length / length,
        location_std=contact.arc_length_std / length,
        estimated_transverse=no_values if contact.transverse_force is None else contact.transverse_force,
        transverse_std=no_values if contact.transverse_force_std is None else contact.transverse_force_std,
        degrees=degrees,
    )


def estimate_contacts(
    layout: MeasurementModel,
    uncertainty: Uncertainty,
    readings: Array,
    contacts: Contacts,
    scale: Scale = UNSCALED,
    estimator: str = ESTIMATOR,
) -> Estimates:
    """Estimates contacts by sensors on the nominal finger.

    Args:
        layout: the sensors on the nominal finger.
        uncertainty: as declared.
        readings: (M, R), of which `contact` gives the posterior as well, or (E, M, R).
        contacts: whose pressure and gravity are measured, and the truth to compare with.
        scale: factors on pressure, gravity and force.
        estimator: its name, see `check_estimator`.
    """
    function, shape = estimator_function(estimator, layout, uncertainty), readings.shape[:-1]
    pressure = np.broadcast_to(scale.pressure * contacts.pressure, shape)
    gravity = np.broadcast_to(np.asarray(scale.gravity)[..., None] * contacts.gravity, (*shape, 3))
    inputs = readings, driving_torque(layout.finger, layout.deformations, pressure), gravity
    estimates = compare(function(*inputs).contact, contacts, layout.deformations != ("bending",))
    scaled = ("estimated_force", "force_std", "estimated_transverse", "transverse_std")
    estimates = estimates._replace(**{name: scale.force * getattr(estimates, name) for name in scaled})
    if len(shape) > 1 or not isinstance(function, ContactShape):
        return estimates
    posterior = function.posterior(*inputs)
    return estimates._replace(
        probability=posterior.probability,
        interval=posterior.force_interval,
        bounds=posterior.force_bounds,
        location_set=posterior.arc_length_set / layout.finger.length,
        transverse_interval=posterior.transverse_force_interval,
    )


def driving_torque(finger: Finger, ways: tuple[str, ...], pressure: Array) -> Array:
    """Torque of pressures of one chamber, (...) Pa, at the joints, by deformation, (..., D) N m."""
    bending = finger.pressure_torque(pressure)
    return np.concatenate([bending, *[np.zeros_like(bending)] * (len(ways) - 1)], axis=-1)


# Gain errors and hysteresis of 1 % at strains up to 0.15, and noise of 0.002, together.
_SINGLE = EstimatorSetup(2, noise=1.0, reading=0.0025)
_MEAN = EstimatorSetup(2, noise=1.0, reading=0.0015, averaged=HELD)
_WRONG = [
    EstimatorSetup(2, model=MODELS[2], stiffness=stiffness, calibration=calibration)
    for calibration, stiffness in product(CALIBRATIONS, (0.1, -0.1))
]
_ALL = (
    *(EstimatorSetup(2), *_WRONG, _SINGLE, _MEAN),
    *(replace(wrong, noise=_MEAN.noise, reading=_MEAN.reading, averaged=HELD) for wrong in _WRONG),
)
SETUPS = tuple(replace(setup, sections=count, borders=borders) for (count, borders), setup in product(LAYOUTS, _ALL))
SHOWN_SETUPS = tuple(replace(setup, borders=LAYOUTS[1][1]) for setup in (_ALL[0], _WRONG[-2], _MEAN))  # in the figure


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


def contact_estimates(contacts: Contacts, estimators: Sequence[str]) -> Iterator[tuple[str, EstimatorSetup, Estimates]]:
    """Estimates of every estimator in all SETUPS, with the names of both."""
    readings = cache(
        lambda sensors: contact_readings(
            sensors.layout(contacts.finger), contacts, sensors.errors, SEEDS, sensors.averaged
        )
    )
    for setup, name in product(SETUPS, estimators):
        sensors = EstimatorSetup(setup.sections, setup.noise, borders=setup.borders, averaged=setup.averaged)
        yield name, setup, calibrated_estimates(setup, readings(sensors), contacts, name)


def calibrated_estimates(
    setup: EstimatorSetup, readings: ContactReadings, contacts: Contacts, estimator: str = ESTIMATOR
) -> Estimates:
    """Estimates contacts after the calibration of a setup in free motion, each (E, M)."""
    nominal = setup.layout(setup.nominal_finger(contacts.finger))
    assert isinstance(nominal, SensorLayout)
    scale = CALIBRATIONS[setup.calibration](nominal, readings.free)
    return estimate_contacts(nominal, setup.uncertainty, readings.pressed, contacts, scale, estimator)
