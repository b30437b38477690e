"""Rate-independent hysteresis: a Prandtl-Ishlinskii model, the weighted sum of play operators.

A play operator of radius r follows the strain with a backlash of r to either side. With radii that double from one to
the next and one weight w for all, the loop of a cycle is as wide as w (stroke - 2 least radius): a share of the stroke,
whatever the stroke. (M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis, Springer 1989; K. Kuhnen,
Modeling, identification and compensation of complex hysteretic nonlinearities, European Journal of Control 9, 2003,
doi:10.3166/ejc.9.407-418.)
"""

import numpy as np

from soft_gripper.arrays import Array

PLAYS = 10
RADII = 0.2 / 2.0 ** np.arange(PLAYS)[:, None]  # strain, (PLAYS, 1): strokes of up to 0.8 have a full loop
FULL_SCALE = 0.1  # strain up to which a sensor at rest is stretched when the hysteresis leaves no error
_FOLLOWED = float(np.maximum(1 - RADII / FULL_SCALE, 0).sum())  # sum of the operators, over the strain, there


def moved_plays(plays: Array, strain: Array) -> Array:
    """The play operators, (..., PLAYS, R), after the strain has become `strain`, (..., R)."""
    strain = strain[..., None, :]
    return np.clip(plays, strain - RADII, strain + RADII)


def lagging_strain(plays: Array, strain: Array, width: float) -> Array:
    """The strain with hysteresis, (..., R), for a width of the loop as a share of the stroke."""
    return (1 - width * _FOLLOWED) * strain + width * plays.sum(axis=-2)
