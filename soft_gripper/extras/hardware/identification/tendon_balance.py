"""Balances springs, weight and pulled tendons of a finger at rest: pulled lengths (R, T) -> joint positions (R, J).

A tendon is a spring that cannot push (`path_drive`), so tensions T and the lengths that they leave slack exclude each
other. With the joints' compliance C, the gradients G = dl/dq of the tendons' lengths and the joints' other torques
f, a shape in balance is  q = C (f - G' T) , and

    T >= 0 ,   w = (G C G' + 1 / stiffness) T - b >= 0 ,   T w = 0 ,   b = pulled - slack - l(0) + l(q) at T = 0 :

a linear complementarity problem with a positive definite matrix, which has one solution (Cottle, Pang and Stone, *The
Linear Complementarity Problem*, section 3.1). Where tendons are not parallel to the axis, or there is weight, l and f
are linearised and the problem is solved again until the shape is still. The inverse of C then has the slope of the
weight's torques besides the springs, and the stiffness of the last tensions against twist.
"""

import numpy as np
from scipy.optimize import nnls

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.path_drive import Tendons
from soft_gripper.fingers.paths import PathsOnChain, length_gradients
from soft_gripper.fingers.spatial_chain import (
    Loads,
    SpatialChain,
    posture,
    spatial_chain,
    torque_slopes,
    torques,
    weights,
)

_MAX_GUESSES = 12  # of the set of taut tendons; then a row is solved by itself
_MAX_ITERATIONS = 200
_MAX_SLOPE_SHARE = 0.99  # of the stiffness of the springs: largest slope of the weight in an iteration
_MAX_POSITION = 100.0  # rad, and m; beyond, the iteration diverges
_BALANCE_TOLERANCE = 1e-10  # rad, and m


def pulled_positions(finger: Finger, pulled: Array, gravity: Array | None = None) -> Array:
    """Joint positions of a finger at rest, rad, and m where joints slide, (R, J) in the order of `spatial_chain`.

    Its T tendons all have a stiffness, and are pulled in by lengths, (R, T) m; gravity is (3,) m/s^2 in B. A row in
    which no balance is found is NaN: the finger buckles under its weight.
    """
    chain, tendons = spatial_chain(finger), Tendons(finger)
    stiffness = np.diag(chain.interleaved(finger.stiffnesses))
    weight = None if gravity is None or not gravity.any() else weights(finger, chain, gravity)
    is_linear = weight is None and tendons.paths.are_parallel
    positions = np.full((len(pulled), len(chain.deformations)), np.nan)
    q: Array = np.zeros(positions.shape)
    tensions: Array = np.zeros(pulled.shape)
    open_rows = np.arange(len(pulled))
    for _ in range(_MAX_ITERATIONS):
        joints = chain.separated(q)
        slopes = chain.interleaved(length_gradients(tendons.paths, joints))
        twist_stiffness = _twist_stiffness(chain, tendons.paths, tensions)
        compliance, free_q = _tendonless_balance(chain, stiffness, twist_stiffness, weight, q)
        stretches = tendons.elongations(joints, pulled[open_rows])
        target = stretches + ((free_q - q)[:, None] @ slopes.swapaxes(-1, -2))[:, 0]
        matrix = slopes @ compliance @ slopes.swapaxes(-1, -2) + np.diag(1 / tendons.stiffness)
        tensions = solve_complementarity(matrix, target)
        last_q, q = q, free_q - (tensions[:, None] @ slopes @ compliance)[:, 0]
        is_still = np.abs(q - last_q).max(axis=1, initial=0.0) < _BALANCE_TOLERANCE
        is_still |= is_linear
        positions[open_rows[is_still]] = q[is_still]
        goes_on = ~is_still & (np.abs(q).max(axis=1, initial=0.0) < _MAX_POSITION)
        open_rows, q, tensions = open_rows[goes_on], q[goes_on], tensions[goes_on]
        if not len(open_rows):
            break
    return positions


def _twist_stiffness(chain: SpatialChain, paths: PathsOnChain, tensions: Array) -> Array:
    """Stiffness that tensions (R, T) add where joints twist, (R, J, J): a tendon off the axis is longer when twisted.

    Without it, the iteration would settle slowly where a heavy load keeps the tendons tense.
    """
    stiffness = tensions @ (paths.share * (paths.x**2 + paths.y**2) / paths.segment_length)
    twist_terms = chain.interleaved({name: stiffness * (name == "twist") for name in dict.fromkeys(chain.deformations)})
    return np.eye(len(chain.deformations)) * twist_terms[:, None]


def _tendonless_balance(
    chain: SpatialChain, stiffness: Array, twist_stiffness: Array, weight: Loads | None, q: Array
) -> tuple[Array, Array]:
    """Compliance of the joints, (..., J, J), and positions without tendons, (..., J), by the weight's slope at q."""
    if weight is None:
        return np.diag(1 / np.diag(stiffness)), 0 * q
    bent_chain = posture(chain, q)
    slopes = _limit_slopes(stiffness, torque_slopes(bent_chain, weight) - twist_stiffness)
    compliance: Array = np.linalg.inv(stiffness - slopes)
    driving = torques(bent_chain, weight) - (slopes @ q[..., None])[..., 0]
    return compliance, (compliance @ driving[..., None])[..., 0]


def _limit_slopes(stiffness: Array, slopes: Array) -> Array:
    """Slopes of the weight's torques, (R, J, J), limited where the springs alone would not hold the weight."""
    try:
        np.linalg.cholesky(stiffness - slopes)
    except np.linalg.LinAlgError:
        root = np.sqrt(np.diag(stiffness))
        scale = np.outer(root, root)
        ratios, modes = np.linalg.eigh(slopes / scale)
        return scale * ((modes * np.minimum(ratios, _MAX_SLOPE_SHARE)[..., None, :]) @ modes.swapaxes(-1, -2))
    return slopes


def solve_complementarity(matrix: Array, target: Array) -> Array:
    """Solves  T >= 0 ,  matrix T - target >= 0  with one of the two 0 in every entry, (R, T).

    The nonzero entries are guessed from the last guess's solution; a row for which this does not settle is solved as
    a nonnegative least squares problem,  | L' T - L^-1 target |  with  matrix = L L' . The matrix is symmetric and
    positive definite, (T, T) or (R, T, T).
    """
    matrix = np.broadcast_to(matrix, (*target.shape, target.shape[1]))
    is_taut, T = target > 0, np.zeros(target.shape)
    open_rows = np.arange(len(target))
    for _ in range(_MAX_GUESSES):
        guess = is_taut[open_rows]
        reduced_matrix = np.where(guess[:, :, None] & guess[:, None, :], matrix[open_rows], np.eye(target.shape[1]))
        T[open_rows] = np.linalg.solve(reduced_matrix, np.where(guess, target[open_rows], 0.0)[..., None])[..., 0]
        slack = (matrix[open_rows] @ T[open_rows, :, None])[..., 0] - target[open_rows]
        is_taut[open_rows] = np.where(guess, T[open_rows] > 0, slack < 0)
        open_rows = open_rows[(is_taut[open_rows] != guess).any(axis=1)]
        if not len(open_rows):
            return T
    for row in open_rows:
        cholesky_factor = np.linalg.cholesky(matrix[row])
        T[row], _ = nnls(cholesky_factor.T, np.linalg.solve(cholesky_factor, target[row]))
    return T
