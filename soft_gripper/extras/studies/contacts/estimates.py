"""Force and location of single contacts as estimated under a condition.

The readings: a finger bends freely for its calibration, is released, and is pressed.

Each posture is held for a fifth of a second, so that sensors with errors read the contact with the
history of a finger in use. Free motion needs no simulation: it is the balance of `resting_angles`.

Self-calibration in free motion: one number, the bend over that of the nominal model.

If nothing is touched, only pressure and weight bend the finger,

    k q = g p + w(q) .

With wrong k or g the nominal finger bends differently from the measured one. Free motion shows the ratio of the two,
but not which of them is wrong, so one has to be trusted. Let c be the number that fits the measured bends best:

    the stiffness is trusted:  k q = c g p + w ,    so every pressure counts c times;
    the chamber is trusted:    k / c  q = g p + w ,  so pressure and weight count c times, and a force 1 / c times.

The second is what `estimation.calibration` finds too, which fits gains and offsets of the sensors besides; here many
sets of sensors are calibrated at once. Where a single force presses follows from how the bends of the sections compare,
and needs neither; how strong it is, needs the stiffness itself.

Leading axes are free; K samples of free motion, S sections, N joints.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.shape_estimator import straight_shape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.evaluation.paper.forces import LAYOUTS
from soft_gripper.extras.studies.contacts.dataset import Contacts, G, read_finger
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.named_estimators import estimator_function
from soft_gripper.scenario.nominal_model import describe_nominal_model, read_nominal_model
from soft_gripper.scenario.schema import NominalConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

_STEPS = 4  # of Newton's method; with a linear law the first is exact
_NOISE = 1.0  # of the readings, equal for all; its size does not matter


class FreeMotion(NamedTuple):
    """The measurements on a finger without contact."""

    readings: Array  # (..., K, paths * S)
    pressure: Array  # (K) Pa
    gravity: Planar | complex  # m/s^2, in the bending plane, z + i x in B, a number or (K)


class Scale(NamedTuple):
    """Factors on pressure, gravity and force, numbers or (...)."""

    pressure: Array | float = 1.0
    gravity: Array | float = 1.0
    force: Array | float = 1.0


def trusting_stiffness(nominal: SensorLayout, free: FreeMotion) -> Scale:
    """The calibration of the pressure gain alone, (...)."""
    driven, weight, theta = _known(nominal, free)
    return Scale(pressure=_ratio(nominal, theta, driven, weight))


def trusting_chamber(nominal: SensorLayout, free: FreeMotion) -> Scale:
    """The calibration of the stiffness alone, (...)."""
    driven, weight, theta = _known(nominal, free)
    ratio = _ratio(nominal, theta, driven + weight, np.zeros_like(weight))
    return Scale(ratio, ratio, 1 / ratio)


def _known(nominal: SensorLayout, free: FreeMotion) -> tuple[Array, Array, Array]:
    """Torques of pressure and of weight, N m, (..., K, N), and the bends of the sections, rad, (..., K, S)."""
    theta = nominal.linear(free.readings, _NOISE).values
    weight = gravity_torque(nominal.finger, nominal.shared_equally(theta), np.asarray(free.gravity)[..., None])
    return np.broadcast_to(nominal.finger.pressure_torque(free.pressure), weight.shape), weight, theta


def _ratio(nominal: SensorLayout, theta: Array, scaled: Array, rest: Array) -> Array:
    """The c with which the torques  c scaled + rest  bend the sections by theta, in the mean over all of them."""
    law, ratio = nominal.finger.joint_law, np.ones(theta.shape[:-2])
    for _ in range(_STEPS):
        q = nominal.finger.angle(ratio[..., None, None] * scaled + rest)
        slope = nominal.sums(scaled / law.slope(q))
        left = theta - nominal.sums(q)
        ratio = ratio + (slope * left).sum(axis=(-2, -1)) / (slope**2).sum(axis=(-2, -1))
    return ratio


HELD, PERIOD = 20, 0.01  # samples of every posture, s between them
PRESSURES = np.array([30e3, 60e3, 90e3, 120e3])  # Pa, of the free motion
HANGING = G + 0j  # m/s^2, gravity in the free motion: the finger hangs


class ContactReadings(NamedTuple):
    """Readings of M contacts, by E sets of sensors."""

    free: FreeMotion  # with readings (E, M, K, paths * S)
    pressed: Array  # (E, M, paths * S)


def ideal_readings(layout: SensorLayout, contacts: Contacts) -> ContactReadings:
    """By one set of sensors without errors."""
    free = layout.response.reading(extension_ratios(layout, _free_angles(layout)))
    pressed = layout.response.reading(extension_ratios(layout, contacts.q))
    return ContactReadings(_motion(np.broadcast_to(free, (1, len(pressed), *free.shape))), pressed[None])


def disturbed_readings(
    layout: SensorLayout, contacts: Contacts, errors: StrainErrors, seeds: int, averaged: int
) -> ContactReadings:
    """By sensors with errors, drawn anew for every seed and every contact.

    Each reading is the mean of the last `averaged` samples, up to HELD, of a posture.
    """
    read = [_disturbed(layout, contacts, errors, seed, averaged) for seed in range(seeds)]
    free, pressed = (np.array(part) for part in zip(*read, strict=True))
    return ContactReadings(_motion(free), pressed)


def _disturbed(
    layout: SensorLayout, contacts: Contacts, errors: StrainErrors, seed: int, averaged: int
) -> tuple[Array, Array]:
    straight, free = np.zeros((1, layout.finger.segments)), _free_angles(layout)
    way = [np.broadcast_to(q, contacts.q.shape) for q in (straight, *free[:, None], straight, contacts.q)]
    ratios = np.repeat(extension_ratios(layout, np.array(way)), HELD, axis=0)  # (time, contact, reading)
    disturbed = disturb(errors, ratios, PERIOD, np.random.default_rng(seed))
    held = layout.response.reading(disturbed).reshape(len(way), HELD, *ratios.shape[1:])
    read = held[:, -averaged:].mean(axis=1)
    return np.moveaxis(read[1:-2], 0, 1), read[-1]


def _free_angles(layout: SensorLayout) -> Array:
    """Joint angles of the free motion, (K, N) rad."""
    return resting_angles(layout.finger, PRESSURES, np.full(len(PRESSURES), HANGING))


def _motion(readings: Array) -> FreeMotion:
    return FreeMotion(readings, PRESSURES, HANGING)


REALISTIC = "realistic"
ESTIMATOR = "contact"  # ours; `contact` from a single sample, without earlier ones
CALIBRATIONS: dict[str, Callable[[SensorLayout, FreeMotion], Scale]] = {
    "none": lambda nominal, free: Scale(),
    "trusting stiffness": trusting_stiffness,
    "trusting chamber": trusting_chamber,
}


SHOWN_LAYOUT = LAYOUTS[1]  # in the figure


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
        return NominalConfig(youngs_modulus=self.youngs_modulus)


# Gain errors and hysteresis of 1 % at strains up to 0.15, and noise of 0.002, together.
_SINGLE, _MEAN = 0.0025, 0.0015
CONDITIONS = (
    Condition(),
    *(Condition(change, calibration) for calibration in CALIBRATIONS for change in ("+10 %", "-10 %")),
    Condition(preset=REALISTIC, averaged=1, reading=_SINGLE),
    Condition(preset=REALISTIC, averaged=HELD, reading=_MEAN),
    *(
        Condition(change, calibration, REALISTIC, HELD, _MEAN)
        for calibration in CALIBRATIONS
        for change in ("+10 %", "-10 %")
    ),
)
SHOWN_CONDITIONS = (
    CONDITIONS[0],
    Condition("+10 %", "trusting chamber"),
    Condition(preset=REALISTIC, averaged=HELD, reading=_MEAN),
)


SEEDS = 20  # sets of sensors with errors


@dataclass(frozen=True)
class ContactEstimate:
    """The estimates of one estimator for M contacts, read by E sets of sensors."""

    estimator: str
    layout: SensorLayout  # as simulated
    condition: Condition
    contact: ContactForce  # each (E, M)


def check_estimator(name: str) -> None:
    """Checks an estimator before any work is done.

    Raises:
        InputError: if it does not exist, does not estimate contacts, or needs earlier samples.
    """
    layout = SensorLayout(read_finger(), 1)
    function = estimator_function(name, layout, Uncertainty())
    if isinstance(function, RecursiveShape):
        raise InputError("contact-trials", "--estimator", name, "needs a recording; contacts are samples by themselves")
    if straight_shape(function, layout).contact is None:
        raise InputError("contact-trials", "--estimator", name, f"does not estimate contact; {ESTIMATOR} does")


def contact_estimates(contacts: Contacts, estimators: Sequence[str]) -> Iterator[ContactEstimate]:
    """Estimates of every estimator, under every layout of sensors and every condition."""
    for sections, borders in LAYOUTS:
        layout = SensorLayout(contacts.finger, sections, borders=borders)
        unlike = {(condition.preset, condition.averaged): condition for condition in CONDITIONS}
        read = {sensors: _read(layout, contacts, condition) for sensors, condition in unlike.items()}
        for condition in CONDITIONS:
            readings = read[condition.preset, condition.averaged]
            for name in estimators:
                found = estimate_contacts(name, layout, condition, readings, contacts)
                yield ContactEstimate(name, layout, condition, found)


def estimate_contacts(
    estimator: str, layout: SensorLayout, condition: Condition, readings: ContactReadings, contacts: Contacts
) -> ContactForce:
    """Contacts as estimated, each (E, M).

    Args:
        estimator: its name, see `check_estimator`.
        layout: as simulated.
        condition: the nominal finger, and how it is calibrated.
        readings: by E sets of sensors.
        contacts: of them pressure and gravity are used.
    """
    nominal = SensorLayout(condition.nominal_finger(layout.finger), layout.sections, borders=layout.borders)
    scale, shape = CALIBRATIONS[condition.calibration](nominal, readings.free), readings.pressed.shape[:-1]
    pressure, gravity = (
        np.broadcast_to(factor * known, shape)
        for factor, known in ((scale.pressure, contacts.pressure), (scale.gravity, contacts.gravity))
    )
    function = estimator_function(estimator, nominal, Uncertainty(reading=condition.reading, bend_per_pressure=EXACT))
    found = function(readings.pressed, nominal.finger.pressure_torque(pressure), gravity).contact
    assert found is not None
    return found._replace(force=scale.force * found.force, force_std=scale.force * found.force_std)


def _read(layout: SensorLayout, contacts: Contacts, condition: Condition) -> ContactReadings:
    if condition.preset is None:
        return ideal_readings(layout, contacts)
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=condition.preset)))
    assert errors is not None
    return disturbed_readings(layout, contacts, errors, SEEDS, condition.averaged)
