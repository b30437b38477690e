"""Forces on several places of one side, from the bends that driving torque and weight do not explain.

Forces f_m >= 0 at many places bend the sections by  M f . Those that leave least unexplained, with a little weight on
their squares so that there is one answer, are a non-negative least-squares problem (Lawson and Hanson 1974, ch. 23).
Few of them are not zero: a contact only pushes, and that alone makes it sparse (Slawski and Hein 2013, doi
10.1214/13-EJS868). How uncertain their sum and centre are follows from those that are not zero and the places beside
them, with friction along the finger at each.

K samples, S sections, N joints.
"""

import numpy as np
from scipy.optimize import nnls

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact_levers import face_offset, unit_torques
from soft_gripper.estimators.single_force import FRICTION, Bends, Fit, misfit
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ContactForce

NEAREST = 0.3  # of the length from the base, where contacts are looked for
_PLACES = 29


def fit_several_forces(layout: SensorLayout, q: Array, bends: Bends, side: Array, usual: float) -> Fit:
    """The forces on one side that explain bends best, as their sum and their centre.

    Args:
        layout: sensors and finger as they are believed to be.
        q: joint angles, rad, about as they are, (K, N).
        bends: what is to be explained, of K samples.
        side: 1 for the inner, -1 for the outer side, (K).
        usual: standard deviation of usual forces, N.
    """
    finger, chain = layout.finger, forward_kinematics(q, layout.finger.segment_length)
    s = np.linspace(NEAREST, 1, _PLACES) * finger.length
    unit = unit_torques(finger, chain, np.broadcast_to(s, (len(q), _PLACES)))
    torques = side[:, None, None] * unit.real
    rubbing = unit.imag - face_offset(finger, s, side[:, None])[..., None] * (unit.real != 0)
    responses, frictions = (_responses(layout, bends, torque) for torque in (torques, rubbing))
    whitening = np.linalg.inv(np.linalg.cholesky(bends.covariance))
    theta = (whitening @ bends.theta[..., None])[..., 0]
    forces = np.array([_fit(*sample, usual) for sample in zip(whitening @ responses, theta, strict=True)])
    total = forces.sum(axis=-1)
    pressing = np.where(total > 0, total, np.nan)[:, None]
    center = forces @ s[:, None] / pressing
    after = _covariance(responses, frictions, forces, bends.covariance, usual)
    stds = (_std_of_sum(after, weights) for weights in (np.ones_like(forces), (s - center) / pressing))
    left = bends.theta - (responses @ forces[..., None])[..., 0]
    contact = ContactForce(side * total, center[:, 0], *stds)
    return Fit(contact, (forces[:, None, :] @ torques)[:, 0], misfit(left, np.linalg.inv(bends.covariance)))


def _responses(layout: SensorLayout, bends: Bends, torques: Array) -> Array:
    """How torques, (K, M, N), bend the sections, (K, S, M)."""
    return np.swapaxes(layout.sums(torques * bends.compliance[..., None, :]), -1, -2)


def _fit(responses: Array, bends: Array, usual: float) -> Array:
    """The forces of one sample at M places, N; whitened."""
    ridge = np.eye(responses.shape[-1]) / usual
    forces, _ = nnls(np.vstack([responses, ridge]), np.concatenate([bends, np.zeros(len(ridge))]))
    return forces


def _covariance(responses: Array, frictions: Array, forces: Array, of_bends: Array, usual: float) -> Array:
    """The covariance of the forces, (K, M, M) N^2, each of which might as well press on the next place beside it."""
    pressing = forces > 0
    near = pressing | ~pressing.any(axis=-1, keepdims=True)  # where none is found there may be one anywhere
    near[:, 1:] |= pressing[:, :-1]
    near[:, :-1] |= pressing[:, 1:]
    friction = FRICTION * forces[:, None, :] * frictions
    uncertain = of_bends + friction @ np.swapaxes(friction, -1, -2)
    before = usual**2 * near[..., None] * np.eye(forces.shape[-1])
    shared = before @ np.swapaxes(responses, -1, -2)
    return before - shared @ np.linalg.solve(responses @ shared + uncertain, np.swapaxes(shared, -1, -2))


def _std_of_sum(covariance: Array, weights: Array) -> Array:
    """The standard deviation of a weighted sum of the forces, (K)."""
    return np.sqrt(((weights[:, None, :] @ covariance)[:, 0] * weights).sum(axis=-1))
