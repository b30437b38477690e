"""Fingers at rest under a pressure and a wrench at the tip, in space, by the statics of their chain."""

from dataclasses import replace

import numpy as np

from soft_gripper.fingers.spatial_chain import Loads, posture, resting_positions, spatial_chain

SPATIAL = ("bending", "sideways", "twist")


def bent(finger, segments, pressure=0.0, force=(0, 0, 0), moment=(0, 0, 0)):
    """The posture in balance, and where the tip is, m; Pa, N and N m."""
    finger = replace(finger, segments=segments, yields=SPATIAL)
    chain, driving = spatial_chain(finger), {"bending": finger.pressure_torque(pressure)}
    place = np.array([[0, 0, chain.segment_length / 2]])
    loads = Loads(np.array([len(chain.deformations)]), place, np.array([force], float), np.array([moment], float))
    q = resting_positions(chain, chain.interleaved(finger.stiffnesses), chain.interleaved(driving), loads)
    at = posture(chain, q)
    return at, loads.positions(at)[0]


def compliance(finger, pressure, direction):
    """Of the tip along axis 0, 1 or 2 of frame B, mm/N, at 0.1 N."""
    force, rest = 0.1 * np.eye(3)[direction], bent(finger, 24, pressure)[1]
    return 1e3 * (bent(finger, 24, pressure, force)[1] - rest)[direction] / 0.1


def with_cloth(finger):
    """A finger whose layer shears as its silicone does."""
    ends = (replace(end, layer_shear_modulus=end.youngs_modulus / 3) for end in (finger.base, finger.tip))
    return replace(finger, **dict(zip(("base", "tip"), ends, strict=True)))
