"""What sensors read in contacts: a finger bends freely for its calibration, is let go, and is pressed.

All is held in turn for a fifth of a second, so that sensors with errors read the contact with the
history of a finger in use. Free motion needs no simulation: it is the balance of `resting_angles`.
"""

from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.evaluation.contacts.bench import G
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.evaluation.contacts.self_calibration import FreeMotion
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

HELD, PERIOD = 20, 0.01  # samples of every posture, s between them
PRESSURES = np.array([30e3, 60e3, 90e3, 120e3])  # Pa, of the free motion
HANGING = G + 0j  # m/s^2, gravity in the free motion: the finger hangs


class Readings(NamedTuple):
    """Of M contacts, by E sets of sensors."""

    free: FreeMotion  # with readings (E, M, K, paths * S)
    pressed: Array  # (E, M, paths * S)


def ideal_readings(layout: SensorLayout, contacts: Contacts) -> Readings:
    """By one set of sensors without errors."""
    free = layout.response.reading(extension_ratios(layout, _free_angles(layout)))
    pressed = layout.response.reading(extension_ratios(layout, contacts.q))
    return Readings(_motion(np.broadcast_to(free, (1, len(pressed), *free.shape))), pressed[None])


def disturbed_readings(
    layout: SensorLayout, contacts: Contacts, errors: StrainErrors, seeds: int, averaged: int
) -> Readings:
    """By sensors with errors: for every seed other ones, and for every contact.

    Each reading is the mean of the last `averaged` samples, up to HELD, of a posture.
    """
    read = [_disturbed(layout, contacts, errors, seed, averaged) for seed in range(seeds)]
    free, pressed = (np.array(part) for part in zip(*read, strict=True))
    return Readings(_motion(free), pressed)


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
