"""A finger at rest between its springs, its weight and tendons of which lengths are pulled in.

A tendon is a spring that cannot push (`path_drive`), so tensions T and the lengths that they leave slack exclude each
other. With the joints' compliance C, the gradients G = dl/dq of the tendons' lengths and what else drives the joints,
f, a shape in balance is  q = C (f - G' T) , and

    T >= 0 ,   w = (G C G' + 1 / stiffness) T - b >= 0 ,   T w = 0 ,   b = pulled - slack - l(0) + l(q) at T = 0 :

a linear complementarity problem with a positive definite matrix, which has one solution (Cottle, Pang and Stone, *The
Linear Complementarity Problem*, section 3.1). Where tendons are not parallel to the axis, or there is weight, l and f
are linearised and the problem is solved again until the shape is still. The inverse of C then has the slope of the
weight's torques besides the springs, and what the last tensions add against twist.
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

_GUESSES = 12  # of the set of taut tendons, after which a row is solved by itself
_MOST_ITERATIONS = 200
_UPHELD = 0.99  # of the stiffness of the springs: the most that a weight's slope takes from it in an iteration
_WILD = 100.0  # rad, and m: the iteration diverges
_BALANCE_TOLERANCE = 1e-10  # rad, and m


def pulled_positions(finger: Finger, pulled: Array, gravity: Array | None = None) -> Array:
    """Joint positions of a finger at rest, rad, and m where joints slide, (R, J) in the order of `spatial_chain`.

    A row in which no balance is found is NaN: the finger buckles under its weight.

    Args:
        finger: whose T tendons all have a stiffness.
        pulled: lengths of its tendons that are pulled in, (R, T) m.
        gravity: (3,) m/s^2 in B; None: none.
    """
    chain, tendons = spatial_chain(finger), Tendons(finger)
    stiffness = np.diag(chain.interleaved(finger.stiffnesses))
    weight = None if gravity is None or not gravity.any() else weights(finger, chain, gravity)
    is_linear = weight is None and tendons.paths.are_parallel
    found = np.full((len(pulled), len(chain.deformations)), np.nan)
    q: Array = np.zeros(found.shape)
    tensions: Array = np.zeros(pulled.shape)
    open_rows = np.arange(len(pulled))
    for _ in range(_MOST_ITERATIONS):
        joints = chain.separated(q)
        slopes = chain.interleaved(length_gradients(tendons.paths, joints))
        untwisting = _untwisting(chain, tendons.paths, tensions)
        compliance, free = _without_tendons(chain, stiffness, untwisting, weight, q)
        stretches = tendons.elongations(joints, pulled[open_rows])
        wanted = stretches + ((free - q)[:, None] @ slopes.swapaxes(-1, -2))[:, 0]
        matrix = slopes @ compliance @ slopes.swapaxes(-1, -2) + np.diag(1 / tendons.stiffness)
        tensions = complementary(matrix, wanted)
        before, q = q, free - (tensions[:, None] @ slopes @ compliance)[:, 0]
        still = np.abs(q - before).max(axis=1, initial=0.0) < _BALANCE_TOLERANCE
        still |= is_linear
        found[open_rows[still]] = q[still]
        goes_on = ~still & (np.abs(q).max(axis=1, initial=0.0) < _WILD)
        open_rows, q, tensions = open_rows[goes_on], q[goes_on], tensions[goes_on]
        if not len(open_rows):
            break
    return found


def _untwisting(chain: SpatialChain, paths: PathsOnChain, tensions: Array) -> Array:
    """Stiffness that tensions (R, T) add where joints twist, (R, J, J): a tendon off the axis is longer when twisted.

    Without it, the iteration would settle slowly where a heavy load keeps the tendons tense.
    """
    by_joint = tensions @ (paths.share * (paths.x**2 + paths.y**2) / paths.segment_length)
    added = chain.interleaved({way: by_joint * (way == "twist") for way in dict.fromkeys(chain.deformations)})
    return np.eye(len(chain.deformations)) * added[:, None]


def _without_tendons(
    chain: SpatialChain, stiffness: Array, untwisting: Array, weight: Loads | None, q: Array
) -> tuple[Array, Array]:
    """Compliance of the joints, (..., J, J), and where they would stand without tendons, by the weight's slope at q."""
    if weight is None:
        return np.diag(1 / np.diag(stiffness)), 0 * q
    at = posture(chain, q)
    slopes = _upheld(stiffness, torque_slopes(at, weight) - untwisting)
    compliance: Array = np.linalg.inv(stiffness - slopes)
    driving = torques(at, weight) - (slopes @ q[..., None])[..., 0]
    return compliance, (compliance @ driving[..., None])[..., 0]


def _upheld(stiffness: Array, slopes: Array) -> Array:
    """Slopes of the weight's torques, (R, J, J), less where the springs alone would not hold it, as the tendons may."""
    try:
        np.linalg.cholesky(stiffness - slopes)
    except np.linalg.LinAlgError:
        root = np.sqrt(np.diag(stiffness))
        scale = np.outer(root, root)
        shares, ways = np.linalg.eigh(slopes / scale)
        held: Array = scale * ((ways * np.minimum(shares, _UPHELD)[..., None, :]) @ ways.swapaxes(-1, -2))
        return held
    return slopes


def complementary(matrix: Array, wanted: Array) -> Array:
    """T >= 0 with  matrix T - wanted >= 0  and one of them 0 in every place, (R, T).

    Which places are not 0 is guessed from the last guess's solution; a row for which this does not settle is solved as
    the nonnegative least squares problem that it is,  | L' T - L^-1 wanted |  with  matrix = L L' .

    Args:
        matrix: symmetric and positive definite, (T, T) or (R, T, T).
        wanted: (R, T).
    """
    matrix = np.broadcast_to(matrix, (*wanted.shape, wanted.shape[1]))
    taut, found = wanted > 0, np.zeros(wanted.shape)
    open_rows = np.arange(len(wanted))
    for _ in range(_GUESSES):
        on = taut[open_rows]
        part = np.where(on[:, :, None] & on[:, None, :], matrix[open_rows], np.eye(wanted.shape[1]))
        found[open_rows] = np.linalg.solve(part, np.where(on, wanted[open_rows], 0.0)[..., None])[..., 0]
        left = (matrix[open_rows] @ found[open_rows, :, None])[..., 0] - wanted[open_rows]
        taut[open_rows] = np.where(on, found[open_rows] > 0, left < 0)
        open_rows = open_rows[(taut[open_rows] != on).any(axis=1)]
        if not len(open_rows):
            return found
    for row in open_rows:
        lower = np.linalg.cholesky(matrix[row])
        found[row], _ = nnls(lower.T, np.linalg.solve(lower, wanted[row]))
    return found
