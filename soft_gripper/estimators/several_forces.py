"""Forces on several places of one side, from the bends that pressure and weight do not explain.

Forces f_m >= 0 at many places bend the sections by  M f . Those that leave least unexplained, with a little weight on
their squares so that there is one answer, are a non-negative least-squares problem (Lawson and Hanson 1974, ch. 23).
Few of them are not zero: a contact only pushes, and that alone makes it sparse (Slawski and Hein 2013, doi
10.1214/13-EJS868).

K samples, S sections, N joints.
"""

import numpy as np
from scipy.optimize import nnls

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact_levers import unit_torques
from soft_gripper.estimators.single_force import Bends, Fit, misfit
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ContactForce

NEAREST = 0.3  # of the length from the base, where contacts are looked for
_PLACES = 29
_LEAST = 1e-9  # N


def fit_several_forces(layout: SensorLayout, q: Array, bends: Bends, side: Array, usual: float) -> Fit:
    """The forces on one side that explain bends best, as their sum and their centre.

    Args:
        layout: sensors and finger as they are believed to be.
        q: joint angles, rad, about as they are, (K, N).
        bends: what is to be explained, of K samples.
        side: 1 for the inner, -1 for the outer side, (K).
        usual: standard deviation of usual forces, N.
    """
    chain = forward_kinematics(q, layout.finger.segment_length)
    s = np.linspace(NEAREST, 1, _PLACES) * layout.finger.length
    torques = side[:, None, None] * unit_torques(layout.finger, chain, np.broadcast_to(s, (len(q), _PLACES))).real
    responses = np.swapaxes(layout.sums(torques * bends.compliance[..., None, :]), -1, -2)
    whitening = np.linalg.inv(np.linalg.cholesky(bends.covariance))
    found = [_fit(W @ M, W @ theta, s, usual) for W, M, theta in zip(whitening, responses, bends.theta, strict=True)]
    forces, stds = (np.array(part) for part in zip(*found, strict=True))
    total = forces.sum(axis=-1)
    contact = ContactForce(side * total, forces @ s / np.maximum(total, _LEAST), stds[:, 0], stds[:, 1])
    left = bends.theta - (responses @ forces[..., None])[..., 0]
    weights = np.linalg.inv(bends.covariance)
    return Fit(contact, (forces[:, None, :] @ torques)[:, 0], misfit(left, weights))


def _fit(responses: Array, bends: Array, s: Array, usual: float) -> tuple[Array, tuple[float, float]]:
    """The forces at places s, (M), N, and the standard deviations of their sum and centre, N and m; whitened."""
    ridge = np.eye(len(s)) / usual
    forces, _ = nnls(np.vstack([responses, ridge]), np.concatenate([bends, np.zeros(len(s))]))
    used, total = forces > 0, max(forces.sum(), _LEAST)
    if not used.any():
        return forces, (usual, float(s[-1]))
    covariance = np.linalg.inv(responses[:, used].T @ responses[:, used] + np.eye(used.sum()) / usual**2)
    levers = (s[used] - forces @ s / total) / total
    variances = covariance.sum(), levers @ covariance @ levers
    return forces, (float(np.sqrt(variances[0])), float(np.sqrt(variances[1])))
