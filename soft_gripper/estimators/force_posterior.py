"""Posterior of one force whose place and direction are unknown, from readings: intervals, bounds and modes.

Force and place trade off: where only one section is bent, a large force near the base and a small one further out
explain the same bends. To linearise at the best of them would claim far too much, so the places and directions are
divided into cells, and all of them count. In a cell a force F bends the sections by  F c ; the bends r, whose
covariance is R, then have

    R_c = R + F_0^2 sum d d^T ,   W = R_c^-1 ,
    I = c^T W c ,   F^ = c^T W r / I ,   sigma = I^-1/2 ,   X = r^T W r - F^2 I ,

with F_0 the best force under R and d the standard deviations of c within the cell. Two answers follow.

The likelihood set needs no prior: every cell and force, at most the largest F_max that the scene exerts, with

    X + ((F - F^) / sigma)^2  <=  m + 3.84 ,   m its minimum .

Its pieces, places that adjoin on one side, are the modes. With 2.71 instead, its largest force is an upper bound.

The posterior has the weights of the cells before, and for log F the density  exp(-F^2 / 2 f^2) , from F_max / 1000 to
F_max, with f the usual force. Force, deviation, interval and probability are all of it. Along a ridge of equal
likelihood the marginal weight of a place is about  p(F^) sigma ~ p(F^) F^ : only a density 1 / F, flat in log F, is
indifferent there; one that is flat in F near zero favours places near the base. Forces far above the usual ones, which
lie at the end of the ridge near the base, are not cell_posterior. In a cell, the factor exp(-F^2 / 2 f^2) turns force,
deviation and misfit into

    F' = F^ / (1 + sigma^2 / f^2) ,   sigma' = sigma / sqrt(1 + sigma^2 / f^2) ,   X' = X + F^^2 / (sigma^2 + f^2) .

The force that is reported is the most probable one, of log F, place and friction together: the cell with the least
X' + log |R_c| - 2 log prior, and F' in it; that is what one fits with a Gaussian prior of the force. On a ridge it is
the smallest force, far out. Its deviation is the root mean square distance of the whole posterior from it, and the
interval is of the same posterior. Of an interval with equal tails, both ends of the ridge are left out, and with them
forces with friction at the cone, so that the shortest one and the most probable force are enclosed as well. With even
odds before, the probability of a contact is

    evidence / (evidence + exp(-r^T R^-1 r / 2) |R|^-1/2) ,   evidence = sum over cells of the integral over F .

Several forces f_j >= 0 on one side have any friction and any places beyond `min_location`. The bound of their sum is
the largest sum with  |r - sum f_j c_j|^2  within 2.71 of its least, in the metric of R: non-negative least
squares with a row that draws the sum up (Lawson and Hanson 1974, ch. 23), as strongly as that allows. It needs no count
of contacts. If no single force explains the bends (`misfit` above 1: several contacts, or a finger unlike the nominal
one), nothing but these bounds is stated, and the probability is found with all variances scaled by this misfit (Birge
1932, doi 10.1103/PhysRev.40.207).

Profile likelihood: Cox and Hinkley (1974), Theoretical Statistics, section 9.3. Leading axes are free; C cells, ordered
by side and place, S sections.
"""

import math
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import LazyArray

DETECTION_PROBABILITY = 0.95  # probability of contact from which it is reported
MAX_LOCATED_SPAN = 0.25  # fraction of the length: a contact within a shorter span is located
ANSWERS = "nothing touches", "touched, place unknown", "touched here", "moving: not known"
NOTHING, SOMEWHERE, HERE, MOVING = 0.0, 1.0, 2.0, 3.0
INTERVAL = "least", "median", "most"  # of the posterior; the outer ones enclose both intervals of 95 %
_SET_CHI_SQUARED, _BOUND_CHI_SQUARED = 3.84, 2.71  # chi-squared of one degree of freedom: 95 % on two sides and on one
_FALSE_ALARM_RATE = 1e-3  # P(noise alone gives a misfit > 1)
_FORCE_DECADES = 3  # decades of forces below the largest
_MAX_PULL = 1e3  # weight that draws to the largest sum, over the largest response
_MAX_ACTIVE_SETS = 50  # sets of positive forces that are tried
_GRADIENT_TOLERANCE, _MULTIPLIER_TOLERANCE, _MIN_PIVOT_RATIO = 1e-9, 1e-7, 1e-10  # relative
_EDGE_COUNT, _REFINEMENTS = 41, 2  # edges of the bins of force, and refinements of those that hold nearly all
_INTERVAL_MASS, _TAIL_MASS, _LOWER_TAIL_COUNT = 0.95, 1e-4, 41
_BATCH_SIZE = 20_000  # integrals of cells computed together: they fit into a processor's cache
_FIRST_FORCE = 1.0  # N, force whose uncertainty within a cell is assumed first, if refined
_MIN_RELATIVE_WEIGHT = 1e-6  # weight of a cell, relative to the largest
_MAX_STDS = 8.0  # standard deviations from the mean, beyond which a normal density is 0
_MAX_STD_RATIO = 0.7  # maximum deviation over mean of a force above 0
_TINY = 1e-30


class ForcePrior(NamedTuple):
    """Prior of a force."""

    usual_force: float  # N, f: larger ones are ever less probable
    max_force: float  # N, maximum that the scene can exert


class Cells(NamedTuple):
    """Possible contacts: C cells; those of one side and place follow each other."""

    response: Array  # (..., C, S) rad/N, bends due to 1 N
    deviations: Array  # (..., C, D, S) rad/N, standard deviations of the response within the cell, independent
    place: NDArray[np.int_]  # (C) number of the place, from 0 at the base to P - 1
    side: NDArray[np.int_]  # (C) rising: -1 and 1 of a finger that only bends, else from 1 on, around it
    prior: Array  # (C) probability
    angle: Array  # (C) rad around the finger, from the inner side toward +y


class ContactPosterior(NamedTuple):
    """Posterior of one contact; forces are absolute values, except in the modes."""

    probability: Array  # (...) of a contact
    answer: Array  # (...) NOTHING, SOMEWHERE or HERE, or MOVING: nothing is detected, but might not be in motion
    interval: LazyArray[Array]  # see `force_interval`
    force_set: Array  # (..., 2) N, least and largest force of the likelihood set; NaN where no force explains the bends
    transverse: LazyArray[Array]  # see `transverse_force_interval`
    bounds: LazyArray[Array]  # see `force_bounds`
    arc_length_set: Array  # (..., 2) m, ends of this set along the finger; NaN there, and where nothing is detected
    modes: LazyArray["Modes"]
    misfit: Array  # (...) normalised, of the best single force, 1 where noise leaves more in 1 of 1000 samples
    shape: LazyArray[Any] | None = None  # the `ShapeEstimate` of the same samples, if it shares their fit

    @property
    def force_interval(self) -> Array:
        """Ends and median, (..., 3) N, given contact; see INTERVAL.

        NaN where no single force explains the bends, and where it is MOVING: it would be that of the prior.
        """
        return self.interval.value

    @property
    def transverse_force_interval(self) -> Array:
        """Ends and median of the transverse force, (..., 3) N; see `force_interval`."""
        return self.transverse.value

    @property
    def force_bounds(self) -> Array:
        """Upper 95 % bounds, (..., 3) N: of a force anywhere, of one beyond `min_location`, of a sum of several there.

        NaN where none is below the largest possible force.
        """
        return self.bounds.value

    @property
    def mode_forces(self) -> Array:
        """Forces of the modes, (..., 2) N, see `Modes`."""
        return self.modes.value.forces

    @property
    def mode_arc_lengths(self) -> Array:
        """Arc lengths of the modes, (..., 2) m."""
        return self.modes.value.arc_lengths

    @property
    def mode_sides(self) -> Array:
        """Sides of the modes, (..., 2) rad around the finger, from the inner side toward +y."""
        return self.modes.value.sides


class Modes(NamedTuple):
    """The two likeliest pieces of the likelihood set, the likelier first; NaN where there is none."""

    forces: Array  # (..., 2) N, positive on the inner side
    arc_lengths: Array  # (..., 2) m
    sides: Array  # (..., 2) rad


class Fits(NamedTuple):
    """Fit of a force in every cell, each (..., C)."""

    force: Array  # N, most likely, of either sign
    std: Array  # N
    misfit: Array  # X, of that force
    log_det_ratio: Array  # log det R_c - log det R


class CellFits(NamedTuple):
    """Most likely force in every cell. Bends and cells are whitened: multiplied by R^-1/2."""

    r: Array  # (..., S)
    cells: Cells
    fits: Fits
    chi_squared: Array  # (..., C), of the best possible force


def whitening_matrix(covariance: Array) -> Array:
    """Inverse square root R^-1/2 of a covariance R, (..., S, S)."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(covariance)))


def whiten(bends: Array, covariance: Array, cells: Cells) -> tuple[Array, Cells]:
    """Multiplies bends of sections, (..., S) rad, and cells by R^-1/2, with R the covariance of the bends, rad^2."""
    W = whitening_matrix(covariance)
    transposed = np.swapaxes(W, -1, -2)
    response, deviations = cells.response @ transposed, cells.deviations @ transposed[..., None, :, :]
    return (W @ bends[..., None])[..., 0], cells._replace(response=response, deviations=deviations)


def fit_cells(r: Array, cells: Cells, max_force: float, refines: bool = False) -> CellFits:
    """Fits the most likely force in every cell.

    Args:
        r: unexplained bends of the sections, whitened, (..., S).
        cells: possible contacts, whitened.
        max_force: possible force, N.
        refines: see below.

    If `refines`, F_0 is the best force under the covariance that 1 N has in the cell, instead of under R. Where
    deviations within a cell change the bends as much as the force does, such as friction on the side of a finger, the
    best force under R is far too small.
    """
    fits = _fits(r, cells, max_force, refines)
    excess = (np.clip(fits.force, 0, max_force) - fits.force) / fits.std
    return CellFits(r, cells, fits, fits.misfit + excess**2)


def contact_posterior(
    cell_fits: CellFits,
    posterior: "CellPosterior",
    transverse: LazyArray["CellPosterior"],
    read_count: Array,
    length: float,
    forces: ForcePrior,
    min_location: float,
    is_moving: Array,
    cells_of_several: Cells,
) -> ContactPosterior:
    """The posterior of one force.

    Args:
        cell_fits: most likely force in every cell.
        posterior: of these, by `cell_posterior`.
        transverse: of the part that bends the finger, by `weighted_posterior`; the first cell is the most probable one.
        read_count: number of sections that are read, (...).
        length: of the finger, m.
        forces: their prior.
        min_location: place from which the second bound holds, m.
        is_moving: 1 where a free finger in motion may have the bends, else 0, (...).
        cells_of_several: possible contacts of several forces, whitened.
    """
    from scipy.special import chdtri

    r, cells, fits, chi_squared = cell_fits
    max_force = forces.max_force
    noise_threshold = chdtri(np.maximum(read_count - 2, 1), _FALSE_ALARM_RATE)
    misfit = chi_squared.min(axis=-1) / noise_threshold
    distribution = _distribution(posterior, max_force)
    probability = _probability(cell_fits, posterior, distribution, forces, np.maximum(misfit, 1.0))
    ends = length / (cells.place.max() + 1) * (cells.place[:, None] + np.array([0.0, 1.0]))  # m, of each cell
    is_anywhere, is_beyond = ends[:, 1] > 0, ends[:, 1] > min_location
    arc_length_set = _arc_length_set(chi_squared, ends)
    is_explained, is_detected = misfit <= 1, probability > DETECTION_PROBABILITY
    is_located = is_explained & (np.ptp(arc_length_set, axis=-1) < MAX_LOCATED_SPAN * length)
    has_range, has_place = is_explained[..., None], (is_explained & is_detected)[..., None]
    answer = np.where(is_detected, np.where(is_located, HERE, SOMEWHERE), np.where(is_moving > 0, MOVING, NOTHING))
    is_known = has_range & (answer != MOVING)[..., None]
    best_force = np.take_along_axis(posterior.force, posterior.best_cell[..., None], axis=-1).clip(0, max_force)
    interval = LazyArray(lambda: np.where(is_known, _force_interval(distribution, best_force), np.nan))

    def transverse_interval() -> Array:
        forces, *_ = transverse.value
        intervals = _force_interval(_distribution(transverse.value, max_force), forces[..., :1])
        return np.where(is_known, intervals, np.nan)

    def upper_bounds() -> Array:
        masks = is_anywhere, is_beyond
        ranges = (_force_range(fits, chi_squared, mask, _BOUND_CHI_SQUARED, max_force) for mask in masks)
        bound_anywhere, bound_beyond = (ends[..., 1] for ends in ranges)
        is_allowed = cells_of_several.place >= cells.place[is_beyond].min()
        sum_bound = _sum_bound(r, cells_of_several, is_allowed, noise_threshold, max_force)
        sum_bound = np.maximum(sum_bound, np.where(is_explained, bound_beyond, 0.0))
        columns = (
            np.where(is_explained, bound_anywhere, max_force),
            np.where(is_explained, bound_beyond, sum_bound),
            sum_bound,
        )
        bounds = np.stack(columns, axis=-1)
        return np.where(bounds < max_force, bounds, np.nan)

    def modes() -> Modes:
        mode_forces, mode_cells = _modes(cell_fits, max_force)
        mode_forces = np.where(has_place, mode_forces, np.nan)
        places = (
            np.where(np.isfinite(mode_forces), values[mode_cells], np.nan)
            for values in (ends.mean(axis=-1), cells.angle)
        )
        return Modes(np.sign(cells.side)[mode_cells] * mode_forces, *places)

    return ContactPosterior(
        probability,
        answer,
        interval,
        np.where(has_range, _force_range(fits, chi_squared, is_anywhere, _SET_CHI_SQUARED, max_force), np.nan),
        LazyArray(transverse_interval),
        LazyArray(upper_bounds),
        np.where(has_place, arc_length_set, np.nan),
        LazyArray(modes),
        misfit,
    )


def one_contact_misfit(bends: Array, covariance: Array, cells: Cells, max_force: float) -> Array:
    """Misfit of the best single force to bends, in variances, (...); see `fit_cells`."""
    return fit_cells(*whiten(bends, covariance, cells), max_force).chi_squared.min(axis=-1)


def _fits(r: Array, cells: Cells, max_force: float, refines: bool) -> Fits:
    """The force in every cell, all whitened."""
    leading_shape = np.broadcast_shapes(r.shape[:-1], cells.response.shape[:-2])
    r, c, deviations = (
        np.broadcast_to(array, (*leading_shape, *array.shape[array.ndim - axes :]))
        for array, axes in ((r, 1), (cells.response, 2), (cells.deviations, 3))
    )
    # (S, ..., 1), (S, ..., C) and (D, S, ..., C): sums over short first axes are quick
    r = np.moveaxis(r, -1, 0)[..., None]
    c = np.moveaxis(c, -1, 0)
    deviations = np.moveaxis(deviations, (-2, -1), (0, 1))
    vectors = [*deviations, c, r]
    products = [
        [np.einsum("s...,s...->...", vector, factor) for factor in vectors[: i + 1]] for i, vector in enumerate(vectors)
    ]
    if not refines:
        return _fit(products, np.clip(products[-1][-2] / (products[-2][-1] + _TINY), 0, max_force), max_force)
    first_fits = _fit(products, np.full(c.shape[1:], _FIRST_FORCE), max_force)
    return _fit(products, np.clip(first_fits.force, 0, max_force), max_force)


def _fit(products: list[list[Array]], guess: Array, max_force: float) -> Fits:
    """Fits of forces for guesses F_0; deviations d of the response make the covariance  M = I + F_0^2 sum d d^T .

    `products` are the scalar products of d, c and r, (..., C), up to the diagonal. Elimination of all d leaves
    c^T M^-1 c , c^T M^-1 r  and  r^T M^-1 r ; the pivots have the determinant of M.
    """
    rows, square = [[*row] for row in products], guess**2
    determinant = np.ones(guess.shape)
    for k in range(len(rows) - 2):
        pivot = 1.0 + square * rows[k][k]
        determinant *= pivot
        factor = square / pivot
        for i in range(k + 1, len(rows)):
            ratio = factor * rows[i][k]
            for j in range(k + 1, i + 1):
                rows[i][j] = rows[i][j] - ratio * rows[j][k]
    (*_, information), (*_, projection, misfit) = rows[-2:]
    information = information + (1e-3 / max_force) ** 2  # where nothing bends, any force is equally likely
    force = projection / information
    return Fits(force, information**-0.5, np.maximum(misfit - force * projection, 0), np.log(determinant))


def _force_range(fits: Fits, chi_squared: Array, mask: NDArray[np.bool_], level: float, max_force: float) -> Array:
    """Least and largest force within `level` of the best of the possible cells, (..., 2) N."""
    limit = np.where(mask, chi_squared, np.inf).min(axis=-1, keepdims=True) + level
    is_inside = mask & (chi_squared <= limit)
    reach = fits.std * np.sqrt(np.maximum(limit - fits.misfit, 0))
    lowest = np.where(is_inside, np.clip(fits.force - reach, 0, max_force), np.inf).min(axis=-1)
    highest = np.where(is_inside, np.clip(fits.force + reach, 0, max_force), -np.inf).max(axis=-1)
    return np.stack([lowest, highest], axis=-1)


def _arc_length_set(chi_squared: Array, ends: Array) -> Array:
    """Ends of the likelihood set along the finger, (..., 2) m, from those of the cells, (C, 2)."""
    is_likely = chi_squared <= chi_squared.min(axis=-1, keepdims=True) + _SET_CHI_SQUARED
    begin = np.where(is_likely, ends[:, 0], np.inf).min(axis=-1)
    end = np.where(is_likely, ends[:, 1], 0.0).max(axis=-1)
    return np.stack([begin, end], axis=-1)


def _sum_bound(r: Array, cells: Cells, mask: NDArray[np.bool_], noise_threshold: Array, max_force: float) -> Array:
    """The bound of the sum of several forces on one side, in the cells `mask`, (...) N."""
    from scipy.optimize import nnls

    response = np.broadcast_to(cells.response, (*r.shape[:-1], *cells.response.shape[-2:]))
    sides = [response[..., mask & (cells.side == side), :] for side in np.unique(cells.side)]
    bound, previous = np.zeros(r.shape[:-1]), [np.zeros(side.shape[-2], bool) for side in sides]
    for sample in np.ndindex(bound.shape):
        columns = [side[sample].T for side in sides]
        best = [nnls(side, r[sample]) for side in columns]
        min_misfit = min(residual_norm for _, residual_norm in best) ** 2
        level = min_misfit + _BOUND_CHI_SQUARED * max(1.0, min_misfit / float(noise_threshold[sample]))
        for i, (forces, residual_norm) in enumerate(best):
            if residual_norm**2 <= level:
                # Those of the sample before are often the right ones.
                is_active = previous[i] if previous[i].any() else forces > 0
                total, previous[i] = _largest_sum(columns[i], is_active, r[sample], level, max_force)
                bound[sample] = max(float(bound[sample]), total)
    return bound


def _largest_sum(
    columns: Array, is_active: NDArray[np.bool_], r: Array, level: float, max_force: float
) -> tuple[float, NDArray[np.bool_]]:
    """Finds the largest sum, N, up to `max_force`, of forces with a misfit up to `level`, and the mask of active ones.

    Drawn to a larger sum, with a multiplier m, forces leave  e = r - C f  with  C^T e <= -m , and equality for those
    above zero. While these are the same, e is linear in m, and the level gives m. Which are above zero is found by
    least squares with this m; those that are `is_active` are tried first.
    """
    from scipy.optimize import nnls

    sizes = np.abs(columns).max(axis=0)
    low, high, max_weight, multiplier = 0.0, np.inf, _MAX_PULL * sizes.max() + _TINY, np.inf
    padded_columns, padded_r = np.empty((len(r) + 1, len(sizes))), np.append(r, 0.0)
    padded_columns[:-1] = columns
    for _ in range(_MAX_ACTIVE_SETS):
        is_active = is_active if is_active.any() else sizes <= sizes.min()
        m, total, is_largest = _sum_at_level(columns, columns[:, is_active], r, level)
        if is_largest or abs(m - multiplier) <= _MULTIPLIER_TOLERANCE * m:  # not best: several sets have these forces
            break
        m = m if low < m < high else (low + high) / 2
        weight = min(math.sqrt(m / (2 * max_force - min(max(total, 0.0), max_force))), max_weight)
        padded_columns[-1], padded_r[-1] = weight, 2 * weight * max_force
        forces, _ = nnls(padded_columns, padded_r)
        is_active = forces > 0
        residual, multiplier = r - columns @ forces, weight**2 * max(2 * max_force - forces.sum(), 0.0)
        low, high = (multiplier, high) if residual @ residual <= level else (low, multiplier)
        if low == multiplier and forces.sum() >= max_force:
            return max_force, is_active
    return min(total, max_force), is_active


def _sum_at_level(columns: Array, active_columns: Array, r: Array, level: float) -> tuple[float, float, bool]:
    """Multiplier m at which forces in active columns have the misfit `level`, their sum, and if it is the largest."""
    right_sides = np.ones((active_columns.shape[1], 2))
    right_sides[:, 0] = r @ active_columns
    solutions = _solve(active_columns.T @ active_columns, right_sides)
    fitted_forces, slope = solutions.T
    fit, slope_residual = (active_columns @ solutions).T
    min_residual = r - fit
    m = math.sqrt(max(level - min_residual @ min_residual, 0.0) / max(slope_residual @ slope_residual, _TINY))
    forces, gradients = fitted_forces + m * slope, columns.T @ (min_residual - m * slope_residual) + m
    is_largest = (forces >= 0).all() and gradients.max() <= _GRADIENT_TOLERANCE * m
    return m, float(forces.sum()), bool(is_largest)


def _solve(matrix: Array, right_sides: Array) -> Array:
    """The least-squares solution of a few equations, without a decomposition unless they are singular."""
    from scipy.linalg.lapack import dposv

    factor, solution, failed = dposv(matrix, right_sides)
    if not failed and (factor.diagonal() ** 2 > _MIN_PIVOT_RATIO * matrix.diagonal()).all():
        return np.asarray(solution)
    solution = np.linalg.lstsq(matrix, right_sides, rcond=None)[0]
    return np.asarray(solution)


def _modes(cell_fits: CellFits, max_force: float) -> tuple[Array, NDArray[np.int_]]:
    """Absolute forces of the modes, (..., 2) N, NaN where there is one piece only, and the likeliest cell of each."""
    cells, chi_squared = cell_fits.cells, cell_fits.chi_squared
    begins = np.flatnonzero(np.diff(cells.place, prepend=-1))  # of each side and place
    sides = len(np.unique(cells.side))
    place_minima = np.minimum.reduceat(chi_squared, begins, axis=-1)
    is_likely = place_minima <= place_minima.min(axis=-1, keepdims=True) + _SET_CHI_SQUARED
    is_best = np.arange(len(begins)) == place_minima.argmin(axis=-1)[..., None]
    grid = (*place_minima.shape[:-1], sides, -1)
    is_joined = _extend_piece(is_best.reshape(grid), is_likely.reshape(grid), wraps=sides > 2).reshape(
        place_minima.shape
    )
    groups = np.repeat(np.arange(len(begins)), np.diff(begins, append=len(cells.place)))
    is_first_piece, is_likely = is_joined[..., groups], is_likely[..., groups]
    other_misfits = np.where(is_likely & ~is_first_piece, chi_squared, np.inf)
    mode_cells = np.stack([chi_squared.argmin(axis=-1), other_misfits.argmin(axis=-1)], axis=-1)
    forces = np.take_along_axis(np.clip(cell_fits.fits.force, 0, max_force), mode_cells, axis=-1)
    forces[..., 1] = np.where(np.isfinite(other_misfits).any(axis=-1), forces[..., 1], np.nan)
    return forces, mode_cells


def _extend_piece(piece: NDArray[np.bool_], is_likely: NDArray[np.bool_], wraps: bool) -> NDArray[np.bool_]:
    """Extends a piece by the likely places connected to it along the finger, and around it, (..., sides, places)."""
    while True:
        longer_piece = _connect_toward_base(piece, is_likely)
        longer_piece |= _connect_toward_base(piece[..., ::-1], is_likely[..., ::-1])[..., ::-1]
        if wraps:
            longer_piece |= is_likely & (np.roll(longer_piece, 1, axis=-2) | np.roll(longer_piece, -1, axis=-2))
        if not wraps or (longer_piece == piece).all():
            return longer_piece
        piece = longer_piece


def _connect_toward_base(piece: NDArray[np.bool_], is_likely: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Likely places connected to a piece toward the base."""
    place_number = np.arange(1, piece.shape[-1] + 1)
    last_piece, last_gap = (
        np.maximum.accumulate(place_number * mask, axis=-1) for mask in (piece & is_likely, ~is_likely)
    )
    return np.asarray(last_piece > last_gap)


class CellPosterior(NamedTuple):
    """Posterior in every cell, each (..., C), with variances scaled by the misfit of the best single force."""

    force: Array  # N, most probable; below 0 where the other side is pressed
    std: Array  # N
    peak: Array  # logarithm of the density of place and log F there
    weight: Array  # of the cell, 1 in all
    mean: Array  # N, of the force
    square: Array  # N^2, mean of the squared force

    @property
    def heights(self) -> Array:
        """Logarithm of the integral of each cell's density of log F, up to a common factor, (..., C)."""
        return np.asarray(self.peak + np.log(self.std))

    @property
    def best_cell(self) -> NDArray[np.int_]:
        """The most probable cell, (...)."""
        return np.asarray(np.where(self.force > 0, self.peak, -np.inf).argmax(axis=-1))


def cell_posterior(cell_fits: CellFits, read_count: Array, forces: ForcePrior) -> CellPosterior:
    """Posterior of forces fitted in every cell; `read_count` is the number of sections or sensors that are read."""
    from scipy.special import chdtri

    fits, cells = cell_fits.fits, cell_fits.cells
    misfit = cell_fits.chi_squared.min(axis=-1) / chdtri(np.maximum(read_count - 2, 1), _FALSE_ALARM_RATE)
    scale = np.maximum(misfit, 1.0)[..., None]
    variance, prior_variance = fits.std**2 * scale, forces.usual_force**2
    shrinkage = prior_variance / (prior_variance + variance)
    force, std = fits.force * shrinkage, np.sqrt(variance * shrinkage)
    misfit = fits.misfit / scale + fits.force**2 / (variance + prior_variance)
    peak = np.log(cells.prior) - (misfit + fits.log_det_ratio) / 2
    inverse, mean, square = _positive_moments(force, std)
    logs = peak + np.log(std * inverse)
    weight = np.exp(logs - logs.max(axis=-1, keepdims=True))
    return CellPosterior(force, std, peak, weight / weight.sum(axis=-1, keepdims=True), mean, square)


def weighted_posterior(force: Array, std: Array, weight: Array) -> CellPosterior:
    """The posterior of a part of the force in cells of given weights, each (..., K)."""
    inverse, mean, square = _positive_moments(force, std)
    peak = np.log(np.maximum(weight, _TINY)) - np.log(std * inverse)
    return CellPosterior(force, std, peak, weight, mean, square)


def _positive_moments(force: Array, std: Array) -> tuple[Array, Array, Array]:
    """Integral of a normal density over F, for F > 0, and the means of F and F^2 under it."""
    from scipy.special import ndtr

    probability = np.maximum(ndtr(force / std), _TINY)
    moment = np.maximum(force * probability + std * np.exp(-((force / std) ** 2) / 2) / np.sqrt(2 * np.pi), _TINY)
    inverse = probability**2 / moment * (1 + np.minimum(std * probability / moment, _MAX_STD_RATIO) ** 2)
    return inverse, probability / inverse, moment / inverse


class _ForceDensities(NamedTuple):
    """Densities over F in the cells of N samples that are not negligible, one sample after the other."""

    begins: NDArray[np.int_]  # (N) of the samples, each of which has one cell at least
    samples: NDArray[np.int_]  # (C) their numbers
    weights: Array  # (C)
    scales: Array  # (C) 1/N, nodes of the table of a normal integral per force
    offsets: Array  # (C) nodes of it at a force of 0

    def integrals(self, edges: Array) -> Array:
        """Integrals of a sample's densities from its first edge up to each, (N, E)."""
        edge_count = max(_BATCH_SIZE // len(self.weights), 1)
        edge_batches = (edges.T[i : i + edge_count] for i in range(0, edges.shape[-1], edge_count))
        cumulative = np.concatenate([self._cumulative_integrals(batch) for batch in edge_batches])
        increments = np.maximum(np.diff(cumulative, axis=0), 0) / np.sqrt(edges[:, 1:] * edges[:, :-1]).T
        cumulative[0] = 0.0
        increments.cumsum(axis=0, out=cumulative[1:])
        return np.asarray(cumulative.T)

    def _cumulative_integrals(self, force: Array) -> Array:
        """Integrals of a sample's densities up to forces, without the factor 1 / F, (E, N)."""
        positions = force.take(self.samples, axis=-1)
        positions *= self.scales
        positions += self.offsets
        fractions = _normal_integral(positions)
        fractions *= self.weights
        return np.add.reduceat(fractions, self.begins, axis=-1)


class _Distribution(NamedTuple):
    """The distribution of the forces of N samples."""

    densities: _ForceDensities
    edges: Array  # (N, E) N
    cumulative: Array  # (N, E) integrals up to the edges

    @property
    def total(self) -> Array:
        """The integral over all forces, (N)."""
        return np.maximum(self.cumulative[:, -1], _TINY)


def _distribution(posterior: CellPosterior, max_force: float) -> _Distribution:
    """Distribution of the forces of every sample; its densities are scaled by the highest."""
    logs = posterior.heights
    weights = np.exp(logs - logs.max(axis=-1, keepdims=True))
    fields = weights, posterior.force, posterior.std
    weights, forces, stds = (values.reshape(-1, values.shape[-1]) for values in fields)
    is_kept = (weights > _MIN_RELATIVE_WEIGHT) & (forces > -_MAX_STDS * stds)
    is_kept[np.arange(len(is_kept)), weights.argmax(axis=-1)] = True
    samples, counts = np.nonzero(is_kept)[0], is_kept.sum(axis=-1)
    begins, weights, forces, stds = counts.cumsum() - counts, weights[is_kept], forces[is_kept], stds[is_kept]
    scales = _NODES_PER_STD / stds
    densities = _ForceDensities(begins, samples, weights, scales, _MAX_STDS * _NODES_PER_STD - forces * scales)
    edges = _geometric_edges(np.full(len(counts), max_force / 10**_FORCE_DECADES), np.full(len(counts), max_force))
    return _Distribution(densities, edges, densities.integrals(edges))


def _probability(
    cell_fits: CellFits, posterior: CellPosterior, distribution: _Distribution, forces: ForcePrior, scale: Array
) -> Array:
    """The probability of contact, (...), with variances scaled, (...)."""
    from scipy.special import exp1

    chi_squared = (cell_fits.r**2).sum(axis=-1)
    max_force = forces.max_force
    peak = posterior.heights.max(axis=-1)
    evidence = np.sqrt(2 * np.pi) * distribution.total.reshape(peak.shape)
    ratios = np.array([max_force / 10**_FORCE_DECADES, max_force]) / forces.usual_force
    prior_integral = -np.diff(exp1(ratios**2 / 2))[0] / 2
    log_odds = peak + np.log(np.maximum(evidence, _TINY) / prior_integral) + chi_squared / scale / 2
    return 1 / (1 + np.exp(np.clip(-log_odds, -700, 700)))


def _force_interval(distribution: _Distribution, best_force: Array) -> Array:
    """The interval of the force, (..., 3) N; it encloses the reported one, (..., 1) N."""
    intervals = _finer_interval(distribution).reshape(*best_force.shape[:-1], len(INTERVAL))
    intervals[..., :1] = np.minimum(intervals[..., :1], best_force)
    intervals[..., -1:] = np.maximum(intervals[..., -1:], best_force)
    return intervals


def _finer_interval(distribution: _Distribution) -> Array:
    """Intervals and the median within, (N, 3) N."""
    densities, edges, total = distribution.densities, distribution.edges, distribution.total[:, None]
    rows, cumulative = np.arange(len(edges)), distribution.cumulative / total
    for _ in range(_REFINEMENTS):  # divides what holds nearly all of it once more
        last = np.minimum((cumulative < 1 - _TAIL_MASS).sum(axis=-1), _EDGE_COUNT - 1)
        first = np.clip((cumulative < _TAIL_MASS).sum(axis=-1) - 1, 0, _EDGE_COUNT - 1)
        lower, edges = cumulative[rows, first], _geometric_edges(edges[rows, first], edges[rows, last])
        cumulative = lower[:, None] + densities.integrals(edges) / total
    return _interval(cumulative, edges)


def _geometric_edges(lowest: Array, highest: Array) -> Array:
    """Edges of bins whose widths grow in proportion to them, from the least to the largest, (..., E)."""
    return np.asarray(lowest[..., None] * (highest / lowest)[..., None] ** _BIN_EDGES)


_BIN_EDGES = np.linspace(0, 1, _EDGE_COUNT)
# Fractions below an interval of 95 %, and those up to its end; the last interval has equal tails.
_TAIL_FRACTIONS = np.geomspace(_TAIL_MASS, 1 - _INTERVAL_MASS - _TAIL_MASS, _LOWER_TAIL_COUNT)
_LOWER_FRACTIONS = np.array([0.0, *_TAIL_FRACTIONS, (1 - _INTERVAL_MASS) / 2])
_QUANTILE_FRACTIONS = np.concatenate([_LOWER_FRACTIONS, _LOWER_FRACTIONS + _INTERVAL_MASS, [0.5]])


def _interval(cumulative: Array, edges: Array) -> Array:
    """Least, median and largest force, (N, 3) N, of the intervals of 95 %, from the fractions up to each edge."""
    fractions = np.clip(_QUANTILE_FRACTIONS, cumulative[:, :1], cumulative[:, -1:])
    rows = np.arange(len(cumulative))
    offsets = 2.0 * np.arange(len(cumulative))[:, None]  # one sample follows the other
    quantiles = np.interp((fractions + offsets).ravel(), (cumulative + offsets).ravel(), edges.ravel()).reshape(
        fractions.shape
    )
    lower, upper = quantiles[:, : len(_LOWER_FRACTIONS)], quantiles[:, len(_LOWER_FRACTIONS) : -1]
    shortest = (upper - lower).argmin(axis=-1)
    low = np.minimum(lower[rows, shortest], lower[:, -1])
    high = np.maximum(upper[rows, shortest], upper[:, -1])
    return np.stack([low, quantiles[:, -1], high], axis=-1)


_NODES_PER_STD = 1024  # of the table of a normal integral, in a standard deviation


def _normal_integral(positions: Array) -> Array:
    """The integral of a normal density up to positions in nodes of a table, within 3e-8: linear between the nodes.

    It overwrites the positions.
    """
    values, changes = _normal_table()
    with np.errstate(invalid="ignore"):  # NaN is kept: whatever its node is
        nodes = positions.astype(np.intp)
    positions -= nodes
    positions *= changes.take(nodes, mode="clip")
    positions += values.take(nodes, mode="clip")
    return positions


@cache
def _normal_table() -> tuple[Array, Array]:
    """The integral at the nodes, and its change up to the next one, 0 at both ends of the table and beyond."""
    from scipy.special import ndtr

    values = ndtr(np.arange(2 * _MAX_STDS * _NODES_PER_STD + 1) / _NODES_PER_STD - _MAX_STDS)
    changes = np.diff(values, append=values[-1:])
    changes[0] = 0.0
    return values, changes
