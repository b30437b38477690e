"""Fingers in static balance in space, and what is believed of their load, by nothing but one force after the other.

Joint positions are in the order of `MeasurementModel.deformations`, (..., D), of fingers that only bend as of those
that leave their plane.
"""

from dataclasses import replace

import numpy as np

from soft_gripper.estimators.mechanics import TIP_FRACTION
from soft_gripper.fingers.spatial_chain import Loads, posture, resting_positions, spatial_chain, torques, weights
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.measurement import spatial_deformations

WAYS = ("bending", "sideways", "twist")
DOWN = np.array([0.0, 0.0, 9.81])  # of a finger that hangs, whose +z points down


def yielding(finger):
    """The same finger, which leaves its plane as well."""
    return replace(finger, yields=WAYS)


def sensors(finger, name="four_faces_and_diagonal", sections=2):
    return sensor_layout(finger, SensorConfig(layout=name, sections=sections))


def by_way(finger, values):
    """Values of the joints along the chain, (..., D), in the order way after way."""
    return values[..., np.argsort(spatial_chain(finger).position_indices(spatial_deformations(finger)))]


def bent_chain(finger, q):
    return posture(spatial_chain(finger), q[..., spatial_chain(finger).position_indices(spatial_deformations(finger))])


def driven(finger, pressure, drive=1.0):
    """Torque of a pressure, times shares, (..., N) or one for all, (..., D)."""
    torque = drive * finger.pressure_torque(np.asarray(pressure, dtype=float))
    return np.concatenate([torque, np.zeros((*torque.shape[:-1], finger.segments * (len(finger.yields) - 1)))], axis=-1)


def pushed(finger, pressure, forces=(0, 0, 0), gravity=DOWN, drive=1.0):
    """Joint positions of a finger under forces at its tip, (..., 3) N."""
    chain, forces = spatial_chain(finger), np.asarray(forces, dtype=float)
    own = weights(finger, chain, np.asarray(gravity, dtype=float))
    own_forces = np.broadcast_to(own.forces, (*forces.shape[:-1], *own.forces.shape[-2:]))
    all_forces = np.concatenate([own_forces, forces[..., None, :]], axis=-2)
    points = np.concatenate([own.points, [[0, 0, finger.segment_length / 2]]])
    loads = Loads(np.append(own.frames, len(chain.deformations)), points, all_forces, np.zeros_like(all_forces))
    return balanced(finger, pressure, loads, drive)


def balanced(finger, pressure, loads, drive=1.0):
    chain = spatial_chain(finger)
    torque = drive * finger.pressure_torque(np.asarray(pressure, dtype=float))
    stiffness = chain.interleaved({way: finger.stiffnesses[way] for way in finger.yields})
    return by_way(finger, resting_positions(chain, stiffness, chain.interleaved({"bending": torque}), loads))


def weight(finger, q, gravity):
    """Torques of its weight, (D,)."""
    loads = weights(finger, spatial_chain(finger), gravity)
    return by_way(finger, torques(bent_chain(finger, q), loads))


def forces_along(finger):
    """Links, places on them, m, and variances of forces that are random along a finger and on its tip, times N^2 m^2.

    Torques of forces are linear in their places, so that Simpson's rule integrates over a link what their squares are.
    """
    ends, found = finger.link_ends, []
    for link, length in enumerate(np.diff(ends)):
        density = 3 * (1 - TIP_FRACTION) * length / finger.length**3
        found += [(link, share * length, weight * density) for share, weight in ((0, 1 / 6), (0.5, 4 / 6), (1, 1 / 6))]
    found.append((finger.segments, ends[-1] - ends[-2], TIP_FRACTION / finger.length**2))
    link, place, variance = (np.array(each) for each in zip(*found, strict=True))
    return spatial_chain(finger).link_frames(link), place[:, None] * np.array([0.0, 0.0, 1.0]), variance


def load_covariance(finger, q, load_pressure):
    """Of the torques of a load on a bent finger, (D, D) (N m)^2, from unit forces, one after the other."""
    at, (frames, points, variances) = bent_chain(finger, q), forces_along(finger)
    found = np.zeros((q.size, q.size))
    for frame, point, variance in zip(frames, points, variances, strict=True):
        for force in np.eye(3):
            torque = by_way(finger, torques(at, Loads(frame[None], point[None], force[None], np.zeros((1, 3)))))
            found += variance * np.outer(torque, torque)
    return (load_pressure * finger.pressure_gain.max()) ** 2 * found


def torque_covariance(finger, load_pressure):
    """The same of a straight finger across it, (N, N) (N m)^2: twice integrated white noise, and a force on the tip."""
    u = 1 - finger.joint_arc_lengths / finger.length
    less, more = np.minimum.outer(u, u), np.maximum.outer(u, u)
    covariance = TIP_FRACTION * np.outer(u, u) + (1 - TIP_FRACTION) * less**2 * (3 * more - less) / 2
    return (load_pressure * finger.pressure_gain.max()) ** 2 * covariance


def polynomials(finger):
    """Along the finger, from -1 at the base to 1 at the tip: 1, x and (3 x^2 - 1) / 2, (3, N)."""
    x = 2 * finger.joint_arc_lengths / finger.length - 1
    return np.stack([x**0, x, 1.5 * x**2 - 0.5])


def bend_stds(assumed):
    """Default standard deviations of the bend per pressure, as fractions, one for each of these polynomials."""
    linear = 0.6 * np.sqrt(max(assumed.bend_per_pressure**2 - 0.005**2, 0))
    return np.array([assumed.bend_per_pressure, linear, 0.6 * linear])
