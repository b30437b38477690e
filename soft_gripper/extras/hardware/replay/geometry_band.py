"""How far the bodies of an arm may be from where its wires place them, and where an arm leaves what was fitted.

The band of a body is a circle that holds it with a probability of 95 %. Its covariance has three parts: that of the
fitted geometry, for which a recording counts as few independent samples, since its errors last; the spread of the
bodies in the fitted recordings; and, beyond the bends and lengths of these, that of the wires. Each wire is taken to be
_SCALE wrong in what it measures there, so that the band widens with the distance from what was fitted.
"""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.replay.arm_estimation import ArmRecording
from soft_gripper.extras.hardware.replay.geometry_fit import FittedGeometry, places
from soft_gripper.extras.hardware.replay.wire_lengths import Sections
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points

# Deviations of the geometry, over those of samples that are as independent as the fit takes them to be
_CORRELATED_SAMPLES = 2.0
_SCALE = 0.02  # standard deviation of the scale of a wire beyond what was fitted
# Square of the distance, in deviations, within which 95 % of a planar normal distribution lie
_NORMAL_95_SQUARED = 5.991
_SLIGHT = 0.05  # of the span that was fitted: no warning if an arm leaves it by less


def body_band(geometry: FittedGeometry, recording: ArmRecording, finger: Finger) -> Array:
    """Radius of the band of every body about its place by arcs, (T, S) m."""
    of = geometry.wires.sections(recording.inner, recording.outer)
    at, _ = places(geometry, finger, *of)
    variants = [
        places(variant, finger, *variant.wires.sections(recording.inner, recording.outer))[0]
        for variant in geometry.variants
    ]
    moved = [at + _CORRELATED_SAMPLES * (place - at) for place in variants]
    beyond = _beyond(geometry, of)
    bends = _SCALE * (np.sqrt(2) * beyond.length / geometry.wires.spacing + beyond.theta)
    lengths = _SCALE * beyond.length / np.sqrt(2)
    for one in np.eye(of.theta.shape[-1]):
        moved += [places(geometry, finger, of.theta + one * bends, of.length)[0]]
        moved += [places(geometry, finger, of.theta, of.length + one * lengths)[0]]
    away = as_points(np.stack(moved) - at)
    covariance = np.einsum("ktsi,ktsj->tsij", away, away) + geometry.spread[:, None, None] ** 2 * np.eye(2)
    radius: Array = np.sqrt(_NORMAL_95_SQUARED * np.linalg.eigvalsh(covariance)[..., -1])
    return radius


def extrapolations(geometry: FittedGeometry, recording: ArmRecording) -> list[str]:
    """Where the sections of a recording leave the lengths and bends that were fitted, as text."""
    of, said = geometry.wires.sections(recording.inner, recording.outer), []
    beyond = _beyond(geometry, of)
    kinds = (
        ("mm long", 1e3, beyond.length, of.length, geometry.lengths),
        ("degrees bent", float(np.degrees(1.0)), beyond.theta, of.theta, geometry.bends),
    )
    for kind, unit, distance, value, fitted in kinds:
        for section in np.flatnonzero(distance.max(axis=0) > _SLIGHT * np.ptp(fitted, axis=0)):
            worst = unit * value[int(np.argmax(distance[:, section])), section]
            least, most = unit * fitted[:, section]
            said.append(f"section {section + 1} is {worst:.0f} {kind}, fitted from {least:.0f} to {most:.0f}")
    return said


def _beyond(geometry: FittedGeometry, of: Sections) -> Sections:
    """By how much bends and lengths lie outside those that were fitted, (T, S) each."""
    ends = (of.theta, geometry.bends), (of.length, geometry.lengths)
    return Sections(*(np.maximum(0, np.maximum(value - most, least - value)) for value, (least, most) in ends))
