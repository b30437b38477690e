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
lie at the end of the ridge near the base, are not believed. In a cell, the factor exp(-F^2 / 2 f^2) turns force,
deviation and misfit into

    F' = F^ / (1 + sigma^2 / f^2) ,   sigma' = sigma / sqrt(1 + sigma^2 / f^2) ,   X' = X + F^^2 / (sigma^2 + f^2) .

The force that is reported is the most probable one, of log F, place and friction together: the cell with the least
X' + log |R_c| - 2 log prior, and F' in it; that is what one fits with a Gaussian prior of the force. On a ridge it is
the smallest force, far out. Its deviation is the root mean square distance of the whole posterior from it, and the
interval is of the same posterior. Of an interval with equal tails, both ends of the ridge are left out, and with them
forces with friction at the cone, so that the shortest one and the most probable force are enclosed as well. With even
odds before, the probability of a contact is

    evidence / (evidence + exp(-r^T R^-1 r / 2) |R|^-1/2) ,   evidence = sum over cells of the integral over F .

Several forces f_j >= 0 on one side, of any friction and spread over any places beyond `nearest`, have as the bound of
their sum the largest with  |r - sum f_j c_j|^2  within 2.71 of its least, in the metric of R: non-negative least
squares with a row that draws the sum up (Lawson and Hanson 1974, ch. 23), as strongly as that allows. It needs no count
of contacts. If no single force explains the bends (`misfit` above 1: several contacts, or a finger unlike the nominal
one), nothing but these bounds is stated, and the probability is found with all variances scaled by this misfit (Birge
1932, doi 10.1103/PhysRev.40.207).

Profile likelihood: Cox and Hinkley (1974), Theoretical Statistics, section 9.3. Leading axes are free; C cells, ordered
by side and place, S sections.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import Later

DETECTED = 0.95  # probability of contact from which a place is stated
LOCATED = 0.25  # of the length: a place known to lie within so much of it is stated as known
ANSWERS = "nothing touches", "touched, place unknown", "touched here", "moving: not known"
NOTHING, SOMEWHERE, HERE, MOVING = 0.0, 1.0, 2.0, 3.0
INTERVAL = "least", "median", "most"  # of the posterior; the outer ones enclose both intervals of 95 %
_SET, _BOUND = 3.84, 2.71  # chi-squared of one degree of freedom: 95 % on two sides and on one
_CHANCE = 1e-3  # that noise alone exceeds a misfit of 1
_DECADES = 3  # of forces, below the largest
_STRONGLY = 1e3  # draws to the largest sum, relative to the largest response
_MOST_SETS, _EQUAL, _SINGULAR = 50, 1e-9, 1e-10  # of forces that are tried; relative
_EDGES, _FINER = 41, 2  # of the bins of force, and how often what holds nearly all is divided again
_INTERVAL, _TAIL, _LOWER_TAILS = 0.95, 1e-4, 41
_FIRST = 1.0  # N, force whose uncertainty within a cell is assumed first, if refined
_NEGLIGIBLE = 1e-6  # weight of a cell, relative to the largest
_BEYOND = 8.0  # standard deviations below 0, of a force that leaves nothing above
_WIDE = 0.7  # deviation over mean of a force above 0, at most
_TINY = 1e-30


class Forces(NamedTuple):
    """Which forces are possible."""

    usual: float  # N, f: larger ones are ever less probable
    largest: float  # N, that the scene can exert


class Cells(NamedTuple):
    """Where and how a force may act: C cells, of which those of one side and place follow each other."""

    response: Array  # (..., C, S) rad/N, bends due to 1 N
    spreads: Array  # (..., C, D, S) rad/N, standard deviations of the response within the cell, independent
    place: NDArray[np.int_]  # (C) number of the place, from 0 at the base to P - 1
    side: NDArray[np.int_]  # (C) rising: -1 and 1 of a finger that only bends, else from 1 on, around it
    prior: Array  # (C) probability
    angle: Array  # (C) rad around the finger, from the inner side toward +y

    def whitened(self, whitening: Array) -> "Cells":
        """Cells for bends multiplied by a matrix, (..., S, S)."""
        turn, spreads = np.swapaxes(whitening, -1, -2), self.spreads
        flat = spreads.reshape(*spreads.shape[:-3], -1, spreads.shape[-1]) @ turn
        return self._replace(response=self.response @ turn, spreads=flat.reshape(*flat.shape[:-2], *spreads.shape[-3:]))


class ContactPosterior(NamedTuple):
    """Knowledge of one contact; forces are absolute values unless they are of a mode."""

    probability: Array  # (...) that something touches
    answer: Array  # (...) NOTHING, SOMEWHERE or HERE, or MOVING: nothing is detected, but would it be?
    interval: Later[Array]  # see `force_interval`
    force_set: Array  # (..., 2) N, least and largest force of the likelihood set; NaN where no force explains the bends
    transverse: Later[Array]  # see `transverse_force_interval`
    bounds: Later[Array]  # see `force_bounds`
    arc_length_set: Array  # (..., 2) m, its ends along the finger; NaN there, and where nothing is detected
    mode_forces: Array  # (..., 2) N, positive on the inner side, the likelier first; NaN where there is none
    mode_arc_lengths: Array  # (..., 2) m
    mode_sides: Array  # (..., 2) rad around the finger, from the inner side toward +y
    misfit: Array  # (...) normalised, of the best single force, 1 where noise leaves more in 1 of 1000 samples

    @property
    def force_interval(self) -> Array:
        """Ends and median, (..., 3) N, given contact; see INTERVAL.

        NaN where no single force explains the bends, and where it is MOVING: it would be that of the prior.
        """
        return self.interval.value

    @property
    def transverse_force_interval(self) -> Array:
        """Ends and median of the transverse force likewise, (..., 3) N."""
        return self.transverse.value

    @property
    def force_bounds(self) -> Array:
        """Upper 95 % bounds, (..., 3) N: of one force anywhere, of one beyond `nearest`, of the sum of several there.

        NaN where none is below the largest possible force.
        """
        return self.bounds.value


class Fits(NamedTuple):
    """The force in every cell, each (..., C)."""

    force: Array  # N, most likely, of either sign
    std: Array  # N
    misfit: Array  # X, of that force
    spread: Array  # log det R_c - log det R


class FittedCells(NamedTuple):
    """The most likely force in every cell. Bends and cells are whitened: multiplied by R^-1/2."""

    whitening: Array  # R^-1/2, (..., S, S)
    r: Array  # (..., S)
    cells: Cells
    fits: Fits
    chi_squared: Array  # (..., C), of the best possible force


def fitted(bends: Array, covariance: Array, cells: Cells, largest: float, refined: bool = False) -> FittedCells:
    """The most likely force in every cell.

    Args:
        bends: of the sections, not explained by what is known, rad, (..., S).
        covariance: of these, rad^2, (..., S, S).
        cells: where the force may act.
        largest: possible force, N.
        refined: see below.

    If `refined`, F_0 is the best force under the covariance that 1 N has in the cell, instead of under R: where what is
    uncertain within a cell changes the bends as much as the force does, as friction on the side of a finger does, the
    best force under R is far too small.
    """
    whitening = np.linalg.inv(np.linalg.cholesky(covariance))
    r, cells = (whitening @ bends[..., None])[..., 0], cells.whitened(whitening)
    fits = _fits(r, cells, largest, refined)
    return FittedCells(whitening, r, cells, fits, _chi_squared(fits, largest))


def contact_posterior(
    found: FittedCells,
    posterior: "Believed",
    transverse: Later["Believed"],
    read: Array,
    length: float,
    forces: Forces,
    nearest: float,
    moving: Array,
    several: Cells | None = None,
) -> ContactPosterior:
    """The posterior of one force.

    Args:
        found: the force `fitted` in every cell.
        posterior: how much that is `believed`.
        transverse: the part of the force that bends the finger, as `weighed`; the first cell is the most probable one.
        read: number of sections that are read, (...).
        length: of the finger, m.
        forces: which are possible.
        nearest: place from which the second bound holds, m.
        moving: 1 where a free finger in motion may have the bends, else 0, (...).
        several: where each of several forces may act, if not in the cells of one.
    """
    from scipy.special import chdtri

    r, cells, fits, chi_squared = found[1:]
    largest = forces.largest
    several = cells if several is None else several.whitened(found.whitening)
    most_of_noise = chdtri(np.maximum(read - 2, 1), _CHANCE)
    misfit = chi_squared.min(axis=-1) / most_of_noise
    masses = _masses_of(posterior, largest)
    probability = _probability(found, posterior, masses, forces, np.maximum(misfit, 1.0))
    ends = length / (cells.place.max() + 1) * (cells.place[:, None] + np.array([0.0, 1.0]))  # m, of each cell
    anywhere, beyond = ends[:, 1] > 0, ends[:, 1] > nearest
    places, (pressing, chosen) = _places(chi_squared, ends), modes(found, largest)
    explained, detected = misfit <= 1, probability > DETECTED
    located = explained & (np.ptp(places, axis=-1) < LOCATED * length)
    stated, placed = explained[..., None], (explained & detected)[..., None]
    answer = np.where(detected, np.where(located, HERE, SOMEWHERE), np.where(moving > 0, MOVING, NOTHING))
    known = stated & (answer != MOVING)[..., None]
    reported = np.take_along_axis(posterior.force, posterior.best[..., None], axis=-1).clip(0, largest)
    interval = Later(lambda: np.where(known, _force_interval(masses, reported), np.nan))

    def across() -> Array:
        believed = transverse.value
        return np.where(known, _force_interval(_masses_of(believed, largest), believed.force[..., :1]), np.nan)

    def bounds() -> Array:
        one, one_beyond = (_range(fits, chi_squared, these, _BOUND, largest)[..., 1] for these in (anywhere, beyond))
        total = _several(r, several, several.place >= cells.place[beyond].min(), most_of_noise, largest)
        total = np.maximum(total, np.where(explained, one_beyond, 0.0))
        stated = np.where(explained, one, largest), np.where(explained, one_beyond, total), total
        below = np.stack(stated, axis=-1)
        return np.where(below < largest, below, np.nan)

    return ContactPosterior(
        probability,
        answer,
        interval,
        np.where(stated, _range(fits, chi_squared, anywhere, _SET, largest), np.nan),
        Later(across),
        Later(bounds),
        np.where(placed, places, np.nan),
        np.where(placed, np.sign(cells.side)[chosen] * pressing, np.nan),
        np.where(placed & np.isfinite(pressing), ends.mean(axis=-1)[chosen], np.nan),
        np.where(placed & np.isfinite(pressing), cells.angle[chosen], np.nan),
        misfit,
    )


def one_contact_misfit(bends: Array, covariance: Array, cells: Cells, largest: float) -> Array:
    """Violation that the best single force leaves of bends, in variances, (...); see `fitted`."""
    return fitted(bends, covariance, cells, largest).chi_squared.min(axis=-1)


def _fits(r: Array, cells: Cells, largest: float, refined: bool) -> Fits:
    """The force in every cell, all whitened."""
    c = cells.response
    if not refined:
        return _fit(r, cells, np.clip(_dot(c, r[..., None, :]) / (_dot(c, c) + _TINY), 0, largest), largest)
    first = _fit(r, cells, np.full(cells.response.shape[:-1], _FIRST), largest)
    return _fit(r, cells, np.clip(first.force, 0, largest), largest)


def _fit(r: Array, cells: Cells, guess: Array, largest: float) -> Fits:
    """Fits for guesses F_0 of the forces: each deviation u of the response turns the identity into I + u u^T.

    Vectors are multiplied by the inverse square root of that, one u after the other.
    """
    spreads = guess[..., None, None] * cells.spreads  # (..., C, D, S)
    leading = np.broadcast_shapes(spreads.shape[:-2], cells.response.shape[:-1], (*r.shape[:-1], 1))
    vectors = np.empty((*leading, spreads.shape[-2] + 2, spreads.shape[-1]))
    vectors[..., 0, :], vectors[..., 1, :], vectors[..., 2:, :] = cells.response, r[..., None, :], spreads
    vectors = vectors.transpose(-1, -2, *range(vectors.ndim - 2)).copy()  # (S, 2 + D, ..., C): sums are quick
    log_determinant = np.zeros(vectors.shape[2:])
    while vectors.shape[1] > 2:
        vectors, u = vectors[:, :-1], vectors[:, -1:]
        square = (u * u).sum(axis=0)
        log_determinant += np.log1p(square[0])
        shrunk = (1 - 1 / np.sqrt(1 + square)) / (square + _TINY)
        vectors = vectors - shrunk * (vectors * u).sum(axis=0) * u
    c, left = vectors[:, 0], vectors[:, 1]
    information = (c * c).sum(axis=0) + (1e-3 / largest) ** 2  # where nothing bends, any force is equally likely
    explained = (c * left).sum(axis=0)
    force = explained / information
    unexplained = np.maximum((left * left).sum(axis=0) - force * explained, 0)
    return Fits(force, information**-0.5, unexplained, log_determinant)


def _dot(x: Array, y: Array) -> Array:
    product: Array = np.einsum("...s,...s->...", x, y)
    return product


def _chi_squared(fits: Fits, largest: float) -> Array:
    """The misfit of the best possible force of every cell, (..., C)."""
    chi_squared: Array = fits.misfit + ((np.clip(fits.force, 0, largest) - fits.force) / fits.std) ** 2
    return chi_squared


def _range(fits: Fits, chi_squared: Array, possible: NDArray[np.bool_], level: float, largest: float) -> Array:
    """Least and largest force within `level` of the best of the possible cells, (..., 2) N."""
    limit = np.where(possible, chi_squared, np.inf).min(axis=-1, keepdims=True) + level
    inside = possible & (chi_squared <= limit)
    reach = fits.std * np.sqrt(np.maximum(limit - fits.misfit, 0))
    least = np.where(inside, np.clip(fits.force - reach, 0, largest), np.inf).min(axis=-1)
    most = np.where(inside, np.clip(fits.force + reach, 0, largest), -np.inf).max(axis=-1)
    return np.stack([least, most], axis=-1)


def _places(chi_squared: Array, ends: Array) -> Array:
    """Ends of the likelihood set along the finger, (..., 2) m, from those of the cells, (C, 2)."""
    likely = chi_squared <= chi_squared.min(axis=-1, keepdims=True) + _SET
    least, most = np.where(likely, ends[:, 0], np.inf).min(axis=-1), np.where(likely, ends[:, 1], 0.0).max(axis=-1)
    return np.stack([least, most], axis=-1)


def _several(r: Array, cells: Cells, beyond: NDArray[np.bool_], most_of_noise: Array, largest: float) -> Array:
    """The bound of the sum of several forces on one side, in the cells `beyond`, (...) N."""
    from scipy.optimize import nnls

    response = np.broadcast_to(cells.response, (*r.shape[:-1], *cells.response.shape[-2:]))
    beyond = beyond & ~_between(response, cells)
    sides = [response[..., beyond & (cells.side == side), :] for side in np.unique(cells.side)]
    bound = np.zeros(r.shape[:-1])
    for sample in np.ndindex(bound.shape):
        columns = [side[sample].T for side in sides]
        best = [nnls(side, r[sample]) for side in columns]
        least = min(left for _, left in best) ** 2
        level = least + _BOUND * max(1.0, least / float(most_of_noise[sample]))
        possible = ((side, forces) for side, (forces, left) in zip(columns, best, strict=True) if left**2 <= level)
        bound[sample] = max(_largest_sum(side, forces, r[sample], level, largest) for side, forces in possible)
    return bound


def _between(response: Array, cells: Cells) -> NDArray[np.bool_]:
    """Cells halfway between two of the same side and place, which do nothing that these do not, (C)."""
    off = np.abs(response[..., 2:, :] + response[..., :-2, :] - 2 * response[..., 1:-1, :])
    halfway = (off <= _EQUAL * np.abs(response[..., 1:-1, :]).max(axis=-1, keepdims=True)).all(axis=-1)
    alike = (cells.place[2:] == cells.place[:-2]) & (cells.side[2:] == cells.side[:-2])
    return np.pad(alike & halfway.all(axis=tuple(range(halfway.ndim - 1))), 1)


def _largest_sum(columns: Array, forces: Array, r: Array, level: float, largest: float) -> float:
    """The largest sum of forces with a misfit of up to `level`, N, not more than `largest`.

    Drawn to a larger sum, with a multiplier m, forces leave  e = r - C f  with  C^T e <= -m , and equality for those
    above zero. While these are the same, e is linear in m, and the level gives m. Which are above zero is found by
    least squares with this m; the first ones are the `forces` that fit best.
    """
    from scipy.optimize import nnls

    sizes = np.abs(columns).max(axis=0)
    low, high, most = 0.0, np.inf, _STRONGLY * sizes.max() + _TINY
    for _ in range(_MOST_SETS):
        pressing = forces > 0 if forces.any() else sizes <= sizes.min()
        m, total, best = _at_level(columns, columns[:, pressing], r, level)
        if best:
            break
        m = m if low < m < high else (low + high) / 2
        weight = min(math.sqrt(m / (2 * largest - min(max(total, 0.0), largest))), most)
        rows = np.vstack([columns, np.full(columns.shape[1], weight)])
        forces, _ = nnls(rows, np.append(r, 2 * weight * largest))
        left, reached = r - columns @ forces, weight**2 * max(2 * largest - forces.sum(), 0.0)
        low, high = (reached, high) if left @ left <= level else (low, reached)
        if low == reached and forces.sum() >= largest:
            return largest
    return min(total, largest)


def _at_level(columns: Array, pressing: Array, r: Array, level: float) -> tuple[float, float, bool]:
    """The multiplier m with which forces in some columns have the misfit `level`, their sum, and if none is larger."""
    sought = np.stack([pressing.T @ r, np.ones(pressing.shape[1])], axis=-1)
    first, more = _solved(pressing.T @ pressing, sought).T
    least, turned = r - pressing @ first, pressing @ more
    m = math.sqrt(max(level - least @ least, 0.0) / max(turned @ turned, _TINY))
    forces, others = first + m * more, columns.T @ (least - m * turned) + m
    best = (forces >= 0).all() and others.max() <= _EQUAL * m
    return m, float(forces.sum()), bool(best)


def _solved(matrix: Array, sought: Array) -> Array:
    """The least-squares solution; of one equation or two, which are the usual numbers, without a decomposition."""
    if len(matrix) == 1:
        return sought / matrix if matrix.item() else np.zeros_like(sought)
    if len(matrix) == 2:
        (a, b), (_, d) = matrix.tolist()
        determinant = a * d - b * b
        if determinant > _SINGULAR * a * d:
            return np.asarray(np.array([[d, -b], [-b, a]]) @ sought / determinant)
    found: Array = np.linalg.lstsq(matrix, sought, rcond=None)[0]
    return found


class Modes(NamedTuple):
    """The two likeliest pieces of the likelihood set; the second has a force of NaN where there is one piece only."""

    forces: Array  # (..., 2) N, absolute values
    cells: NDArray[np.int_]  # (..., 2) the likeliest of each


def modes(found: FittedCells, largest: float) -> Modes:
    """The modes of a likelihood set."""
    cells, chi_squared = found.cells, found.chi_squared
    begins = np.flatnonzero(np.diff(cells.place, prepend=-1))  # of each side and place
    sides = len(np.unique(cells.side))
    by_place = np.minimum.reduceat(chi_squared, begins, axis=-1)
    likely = by_place <= by_place.min(axis=-1, keepdims=True) + _SET
    best = np.arange(len(begins)) == by_place.argmin(axis=-1)[..., None]
    grid = (*by_place.shape[:-1], sides, -1)
    piece = _joined(best.reshape(grid), likely.reshape(grid), around=sides > 2).reshape(by_place.shape)
    groups = np.repeat(np.arange(len(begins)), np.diff(begins, append=len(cells.place)))
    first, likely = piece[..., groups], likely[..., groups]
    others = np.where(likely & ~first, chi_squared, np.inf)
    chosen = np.stack([chi_squared.argmin(axis=-1), others.argmin(axis=-1)], axis=-1)
    forces = np.take_along_axis(np.clip(found.fits.force, 0, largest), chosen, axis=-1)
    forces[..., 1] = np.where(np.isfinite(others).any(axis=-1), forces[..., 1], np.nan)
    return Modes(forces, chosen)


def _joined(piece: NDArray[np.bool_], likely: NDArray[np.bool_], around: bool) -> NDArray[np.bool_]:
    """The likely places that join on to a piece along the finger, and around it, (..., sides, places)."""
    while True:
        wider = _reached(piece, likely) | _reached(piece[..., ::-1], likely[..., ::-1])[..., ::-1]
        if around:
            wider |= likely & (np.roll(wider, 1, axis=-2) | np.roll(wider, -1, axis=-2))
        if not around or (wider == piece).all():
            return wider
        piece = wider


def _reached(piece: NDArray[np.bool_], likely: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """The likely places from which others lead back, toward the base, to a piece."""
    number = np.arange(1, piece.shape[-1] + 1)
    begun, ended = (np.maximum.accumulate(number * each, axis=-1) for each in (piece & likely, ~likely))
    return np.asarray(begun > ended)


class Believed(NamedTuple):
    """The posterior in every cell, each (..., C), with variances scaled by what no single force explains."""

    force: Array  # N, most probable; below 0 where the other side is pressed
    std: Array  # N
    peak: Array  # logarithm of the density of place and log F there
    weight: Array  # of the cell, 1 in all
    mean: Array  # N, of the force
    square: Array  # N^2, mean of the squared force

    @property
    def heights(self) -> Array:
        """Logarithm of the integral of each cell's density of log F, but for a factor, (..., C)."""
        return np.asarray(self.peak + np.log(self.std))

    @property
    def best(self) -> NDArray[np.int_]:
        """The most probable cell, (...)."""
        return np.asarray(np.where(self.force > 0, self.peak, -np.inf).argmax(axis=-1))


def believed(found: FittedCells, read: Array, forces: Forces) -> Believed:
    """The posterior of forces that are fitted in every cell, of sections or sensors of which (...) are read."""
    from scipy.special import chdtri

    fits, cells = found.fits, found.cells
    misfit = found.chi_squared.min(axis=-1) / chdtri(np.maximum(read - 2, 1), _CHANCE)
    scale = np.maximum(misfit, 1.0)[..., None]
    variance, usual = fits.std**2 * scale, forces.usual**2
    share = usual / (usual + variance)
    force, std = fits.force * share, np.sqrt(variance * share)
    peak = np.log(cells.prior) - (fits.misfit / scale + fits.force**2 / (variance + usual) + fits.spread) / 2
    inverse, mean, square = _moments(force, std)
    logs = peak + np.log(std * inverse)
    weight = np.exp(logs - logs.max(axis=-1, keepdims=True))
    return Believed(force, std, peak, weight / weight.sum(axis=-1, keepdims=True), mean, square)


def weighed(force: Array, std: Array, weight: Array) -> Believed:
    """The posterior of a part of the force in cells of given weights, each (..., K)."""
    inverse, mean, square = _moments(force, std)
    peak = np.log(np.maximum(weight, _TINY)) - np.log(std * inverse)
    return Believed(force, std, peak, weight, mean, square)


def _moments(force: Array, std: Array) -> tuple[Array, Array, Array]:
    """Of a normal density by 1 / F over F > 0: its integral, and the mean of F and of its square.

    Integrals by 1 / F, 1 and F; the first from the others, by the variance.
    """
    from scipy.special import ndtr

    above = np.maximum(ndtr(force / std), _TINY)
    moment = np.maximum(force * above + std * np.exp(-((force / std) ** 2) / 2) / np.sqrt(2 * np.pi), _TINY)
    inverse = above**2 / moment * (1 + np.minimum(std * above / moment, _WIDE) ** 2)
    return inverse, above / inverse, moment / inverse


class _Masses(NamedTuple):
    """The densities of a sample's cells over F, and their integrals."""

    weights: Array  # (C), of cells that are not negligible
    forces: Array  # (C) N
    stds: Array  # (C) N
    edges: Array  # (E) N
    upto: Array  # (E) integrals up to the edges

    @property
    def total(self) -> float:
        """The integral over all forces."""
        return max(float(self.upto[-1]), _TINY)


def _masses_of(posterior: Believed, largest: float) -> list[_Masses]:
    """The densities of each sample, scaled by the highest."""
    logs, edges = posterior.heights, _divided(largest / 10**_DECADES, largest)
    weights = np.exp(logs - logs.max(axis=-1, keepdims=True))
    flat = (values.reshape(-1, values.shape[-1]) for values in (weights, posterior.force, posterior.std))
    found = []
    for sample in zip(*flat, strict=True):
        kept = (sample[0] > _NEGLIGIBLE) & (sample[1] > -_BEYOND * sample[2])
        weights, centers, stds = (values[kept] for values in sample)
        found.append(_Masses(weights, centers, stds, edges, _integrals(weights, centers, stds, edges)))
    return found


def _probability(found: FittedCells, posterior: Believed, masses: list[_Masses], forces: Forces, scale: Array) -> Array:
    """The probability of contact, (...), with variances scaled, (...)."""
    from scipy.special import exp1

    nothing, largest, best = (found.r**2).sum(axis=-1), forces.largest, posterior.heights.max(axis=-1)
    evidence = np.reshape([np.sqrt(2 * np.pi) * each.total for each in masses], best.shape)
    of_prior = (exp1((largest / 10**_DECADES / forces.usual) ** 2 / 2) - exp1((largest / forces.usual) ** 2 / 2)) / 2
    log_odds = best + np.log(np.maximum(evidence, _TINY) / of_prior) + nothing / scale / 2
    return 1 / (1 + np.exp(np.clip(-log_odds, -700, 700)))


def _force_interval(masses: list[_Masses], reported: Array) -> Array:
    """The interval of the force, (..., 3) N; it encloses the reported one, (..., 1) N."""
    intervals = np.array([_finer_interval(mass) for mass in masses]).reshape(*reported.shape[:-1], len(INTERVAL))
    intervals[..., :1] = np.minimum(intervals[..., :1], reported)
    intervals[..., -1:] = np.maximum(intervals[..., -1:], reported)
    return intervals


def _finer_interval(masses: _Masses) -> Array:
    """Interval of one sample and the median within, (3) N."""
    cells, edges, total = masses[:3], masses.edges, masses.total
    before, upto = 0.0, masses.upto / total
    for _ in range(_FINER):  # divides what holds nearly all of it once more
        within = np.clip(np.searchsorted(upto, (_TAIL, 1 - _TAIL)) - np.array([1, 0]), 0, len(edges) - 1)
        before, edges = float(upto[within[0]]), _divided(*edges[within])
        upto = before + _integrals(*cells, edges) / total
    return _interval(upto, edges)


def _divided(least: float, most: float) -> Array:
    """Edges of bins whose widths grow in proportion to them, from the least to the largest, (E)."""
    return np.asarray(least * (most / least) ** _BIN_EDGES)


_BIN_EDGES = np.linspace(0, 1, _EDGES)
# Shares below an interval of 95 %, and those up to its end; the last interval has equal tails.
_BELOW = np.array([0.0, *np.geomspace(_TAIL, 1 - _INTERVAL - _TAIL, _LOWER_TAILS), (1 - _INTERVAL) / 2])
_SHARES = np.concatenate([_BELOW, _BELOW + _INTERVAL, [0.5]])


def _interval(upto: Array, edges: Array) -> Array:
    """Least, median and largest force, (3) N, of the intervals of 95 %, from the shares up to each edge."""
    found = np.interp(_SHARES, upto, edges)
    least, most = found[: len(_BELOW)], found[len(_BELOW) : -1]
    shortest = int((most - least).argmin())
    return np.array([min(least[shortest], least[-1]), found[-1], max(most[shortest], most[-1])])


def _integrals(weights: Array, forces: Array, stds: Array, edges: Array) -> Array:
    """Integrals of the cells' densities over F, from the first edge up to each, (E)."""
    from scipy.special import ndtr

    below = ndtr((edges[:, None] - forces) / stds) @ weights
    between = np.maximum(np.diff(below), 0) / np.sqrt(edges[1:] * edges[:-1])
    return np.concatenate([[0.0], between.cumsum()])
