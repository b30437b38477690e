"""Weighs the mass at the tip of an identified finger by the shape in which it rests: settled states -> mass and band.

A finger that was identified in known states, at least one of them with a known mass, rests in others where tendons,
springs and weight balance. With markers p of states under an unknown mass m, predicted as p(m), Gauss-Newton steps

    m + (J' (p - p(m))) / (J' J) ,   J = dp/dm ,

over all rows of a recording lead to the mass on which it agrees with the markers best; a last one over the rows of a
window gives that of the window. The place of the base is not known, so a mean offset is removed from the markers of the
recording.

The band is the mass's standard deviation times that of 95 % of a normal distribution, and has two parts. Residuals r of
an inexact model are correlated among markers and in time, so the variance is that of the sum of  J_i . r_i  over N rows
i, of which each counts as  1 / correlation time  (`correlation_time`; Newey and West, *Econometrica* 55, 1987):

    std(m) = sqrt(N var(J_i . r_i) correlation time) / (J' J) .

The other part is the uncertainty of the fit. With C the covariance of its parameters, and G the changes of markers by
these,

    std(m)^2 = g' C g ,   g = G' J / (J' J) .

It includes the scale: modulus, density and stiffness of tendons may change in proportion without a change of shape,
unless a load is known. A single load that is small beside the finger's own weight leaves it open.

Both parts suppose that the model errs in a new shape as in the fitted ones. Where tendons are pulled differently, the
band is  sqrt(1 + growth^2 d)  times as wide, d being the mean distance of the rows from the nearest fitted pulled
lengths (`fitted_states`). The growth is learned in the fit (`learned_growth`), by leaving out regions of pulled lengths
under any load, so that 95 % of these bands hold the mass that is weighed there. A mass between fitted
ones is interpolated; its distance from the range of fitted masses counts in d as pulled lengths do.

With a recording of much the same motion without a load, the errors that the model makes in it where the tendons are
pulled most alike are subtracted from those of the loaded one, as a balance is tared: common errors of the model
cancel.

An error that lasts longer than the window, such as a tendon that has slackened since, is not in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.fitted_range import LeftOut, learned_widths, regions_left_out
from soft_gripper.extras.hardware.identification.confidence import (
    UNOBSERVABLE,
    ConfidenceConfig,
    confidence_of,
    correlation_time,
    mean_correlation_time,
    square_root,
)
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.model_band import far_rows
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    SettledStates,
    balanced_rows,
    balanced_series,
    marker_slopes,
    note_unbalanced,
    state_errors,
)
from soft_gripper.files.document import require
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, spread_of

_NORMAL_95 = 1.96
_MASS_STEP = 0.02  # kg, of the finite differences
_ITERATIONS = 4
_MIN_ROWS = 10  # rows of a window
_REGION_COUNTS = (2, 4, 8)  # regions of equal numbers of rows, in which a mass is weighed without them
_PULL_TOLERANCE = 0.2  # share of the range of the pulled lengths


@dataclass(frozen=True)
class Weighing:
    """A row of the table: the mass at the tip, from all rows of a span of time."""

    recording: str
    begin_s: Annotated[float, ".0f"]
    end_s: Annotated[float, ".0f"]
    rows: int
    load_g: Annotated[float, ".1f"]
    band_g: Annotated[float, ".1f"]  # to either side, 95 %
    far_percent: Annotated[float, ".0f"]  # of its rows, far from what was fitted; NaN: not known
    named_g: Annotated[float, "g"]  # by the file's name; 0 if it names none


class KeptFit(NamedTuple):
    """Stored fit of a finger: its fitted states and confidence."""

    states: FittedStatesConfig
    confidence: ConfidenceConfig


def weigh(
    model: Model, states: SettledStates, window: float, tare: SettledStates | None = None, fitted: KeptFit | None = None
) -> list[Weighing]:
    """Weighs the load on the tip in every window of a recording, s, and in the last row over all of it.

    The stated load is not used but named in the result. A rest that is shorter than half a window belongs to the last.
    In the states of a tare, without a load, tendons are pulled much as in this recording. Without a kept fit, the
    finger is exact.
    """
    require(window > 0, states.name, "--window", window, "give a span of time, s")
    offset = np.zeros(states.markers.shape) if tare is None else _tare_errors(model, tare, states)
    mass, error, slope = _linearize_mass(model, states, offset)
    require(states.time is not None, states.name, "time", None, "the rows need times for windows")
    assert states.time is not None
    elapsed = states.time - states.time[0]
    window_count = max(round(float(elapsed[-1]) / window), 1)
    window_numbers = np.minimum((elapsed / window).astype(int), window_count - 1)
    note_unbalanced(states, error + slope)
    is_balanced = balanced_rows(error + slope)
    row_count = len(is_balanced)
    terms: tuple[Array, Array, Array] = np.full(row_count, np.nan), np.zeros(row_count), np.zeros((row_count, 0))
    if fitted is not None:
        terms = _fit_terms(fitted, model, replace(states, load=mass), slope)
    is_far, band_growth, deviations = terms
    weighings = []
    for rows in [*(is_balanced & (window_numbers == i) for i in range(window_count)), is_balanced]:
        expected = f"a window needs at least {_MIN_ROWS} rows: make it longer"
        require(int(rows.sum()) >= _MIN_ROWS, states.name, "--window", window, expected)
        mass_change, band = _weigh_rows(error[rows], slope[rows], deviations[rows])
        band *= float(np.sqrt(1 + band_growth[rows].mean()))
        begin, end = elapsed[rows][[0, -1]]
        span = states.name, float(begin), float(end), int(rows.sum())
        far = 100 * float(is_far[rows].mean())
        weighings.append(Weighing(*span, 1e3 * (mass + mass_change), 1e3 * band, far, 1e3 * states.load))
    return weighings


def _fit_terms(fitted: KeptFit, model: Model, states: SettledStates, slope: Array) -> tuple[Array, Array, Array]:
    """Mask of the rows far from the fitted states, growth^2 d, (R,), and deviations of the mass, (R, P)."""
    confidence, name = fitted.confidence, states.name
    free = confidence.parameters(model)
    expected = f"the finger has {len(free.names)} numbers of these keys: is it another one's?"
    require(len(free.names) == len(confidence.std), name, "confidence", len(confidence.std), expected)
    parameter_slopes = marker_slopes(free, free.start, states, np.full(len(states.pulled), True))
    kept_states = fitted.states.fitted
    loads = kept_states.states[:, -1]
    load_distance = abs(states.load - np.clip(states.load, loads.min(), loads.max())) / kept_states.spread[-1]
    distance = np.hypot(kept_states.part(slice(-1)).distance(states.pulled), load_distance)
    is_far, band_growth = far_rows(fitted.states, states).astype(float), confidence.load_growth**2 * distance
    return is_far, band_growth, _mass_deviations(parameter_slopes, confidence.covariance, slope)


def _mass_deviations(parameter_slopes: Array, covariance: Array, slope: Array) -> Array:
    """Contributions of R rows to J' G R, (R, P): changes of the weighed mass by P independent unknowns, C = R R'.

    `parameter_slopes` are derivatives of the markers by the parameters, (R M 3, P).
    """
    unit_slopes = parameter_slopes @ square_root(covariance)
    return np.einsum("rmi,rmip->rp", np.nan_to_num(slope), unit_slopes.reshape(*slope.shape, -1))


def learned_growth(identified: IdentifiedStates) -> float:
    """Growth of the band of a weighed mass with the distance of pulled lengths; 0: no recording has a load.

    It is learned to the first order, from fits without a region of pulled lengths, by the mass of each recording there.
    """
    fit, recording_count = identified.fit, len(identified.left_out)
    states, errors = identified.states[:recording_count], identified.errors[:recording_count]
    if not any(run.load for run in states):
        return 0.0
    slope = np.concatenate([_mass_slope(identified.model, run, run.load)[1] for run in states])
    size, is_balanced = slope[0].size, balanced_rows(slope)
    residuals, parameter_slopes = fit.residuals.reshape(slope.shape), fit.slopes.reshape(*slope.shape, -1)
    recording = np.repeat(np.arange(recording_count), [len(run.pulled) for run in states])
    pulled_lengths = np.concatenate([run.pulled for run in states])
    shapes = FittedStates(pulled_lengths, np.full(pulled_lengths.shape[1], spread_of(pulled_lengths)))
    lasting = mean_correlation_time(balanced_series(errors))

    def leave_out(region: NDArray[np.bool_]) -> LeftOut:
        is_kept = np.repeat(~region, size)
        unknown_change = fit.change_without(is_kept, UNOBSERVABLE, fit.free.scales)
        covariance = confidence_of(fit.free, fit.x, fit.residuals[is_kept], fit.slopes[is_kept], lasting).covariance
        recording_rows = [np.flatnonzero(region & is_balanced & (recording == i)) for i in range(recording_count)]
        masses, distances = [], []
        for rows in [rows for rows in recording_rows if len(rows) >= _MIN_ROWS]:
            mass_slopes, key_slopes = _center(slope[rows]), _center(parameter_slopes[rows])
            deviations = _mass_deviations(key_slopes.reshape(-1, len(unknown_change)), covariance, mass_slopes)
            masses.append(_weigh_rows(_center(residuals[rows]) + key_slopes @ unknown_change, mass_slopes, deviations))
            distances.append(shapes.leave_out(region).distance(pulled_lengths[rows]).mean())
        changes, band = np.array(masses).reshape(-1, 2).T
        return LeftOut(np.abs(changes / band)[:, None], np.sqrt(distances)[:, None])

    regions = [shapes.regions(), *(shapes.halves(max_regions) for max_regions in _REGION_COUNTS)]
    left_out = tqdm(regions_left_out(regions, leave_out), desc="bands of loads", unit="region", dynamic_ncols=True)
    return learned_widths(np.ones((1, 1)), [*left_out]).growth


def _center(values: Array) -> Array:
    """Values of markers, (R, M, 3, ...), without their mean."""
    return values - values.mean(axis=(0, 1))


def _tare_errors(model: Model, tare: SettledStates, states: SettledStates) -> Array:
    """Errors of the unloaded model at the most similar pulled lengths of the tare, (R, M, 3) m."""
    error, pull_tree = state_errors(model, replace(tare, load=0.0)), cKDTree(tare.pulled)
    distances, nearest = pull_tree.query(states.pulled)
    reach = float(np.ptp(tare.pulled, axis=0).max())
    percent = f"{100 * _PULL_TOLERANCE:.0f} %"
    expected = f"pulls no tendons as this recording does: rows are {percent} of the range apart, or more"
    require(float(np.median(distances)) <= _PULL_TOLERANCE * reach, states.name, "--tare", tare.name, expected)
    return error[nearest]


def _linearize_mass(model: Model, states: SettledStates, offset: Array) -> tuple[float, Array, Array]:
    """Mass at which a finger agrees best, or 0; errors of the markers, and their slopes by the mass, (R, M, 3).

    `offset` are the errors of the model without a load, (R, M, 3) m, which are subtracted.
    """
    mass = 0.0
    for _ in range(_ITERATIONS):
        error, slope = _mass_slope(model, states, mass)
        error = error - offset
        last_mass, mass = mass, max(mass - float(np.nansum(slope * error) / np.nansum(slope**2)), 0.0)
    return last_mass, error, slope


def _mass_slope(model: Model, states: SettledStates, mass: float) -> tuple[Array, Array]:
    """Errors of the markers under a mass at the tip, kg, and their slopes by it, (R, M, 3)."""
    error, heavier_error = (state_errors(model, replace(states, load=m)) for m in (mass, mass + _MASS_STEP))
    return error, (heavier_error - error) / _MASS_STEP


def _weigh_rows(error: Array, slope: Array, deviations: Array) -> tuple[float, float]:
    """Change of the mass with which R rows agree best, and its band, kg; the band includes `deviations`, (R, P)."""
    strength = float((slope**2).sum())
    mass_change = -float((slope * error).sum()) / strength
    sums = (slope * (error + slope * mass_change)).sum(axis=(1, 2))
    variance = len(sums) * sums.var() * correlation_time(sums) + (deviations.sum(axis=0) ** 2).sum()
    return mass_change, _NORMAL_95 * float(np.sqrt(variance)) / strength


def weighing_figure(weighings: Sequence[Weighing]) -> Figure:
    """Plots the mass in every window with its band, and the mass in the file's name, a panel for each recording."""
    names = list(dict.fromkeys(row.recording for row in weighings))
    with plt.rc_context(STYLE):
        figure = plt.figure(figsize=(1.2 + 2.6 * len(names), 2.8), constrained_layout=True)
        axes = figure.subplots(1, len(names), sharey=True, squeeze=False)
        for panel, name in zip(axes[0], names, strict=True):
            *windows, overall = [row for row in weighings if row.recording == name]
            middles = [(row.begin_s + row.end_s) / 2 for row in windows]
            loads, bands = [row.load_g for row in windows], [row.band_g for row in windows]
            style = {"fmt": "o", "ms": 4, "capsize": 3, "color": ESTIMATOR_COLORS[5], "label": "estimated, 95 %"}
            panel.errorbar(middles, loads, bands, **style)
            panel.axhline(overall.named_g, color="0.35", lw=1, ls="--", label="hung on the tip")
            panel.set(title=name, xlabel="time [s]", xlim=(0, None))
        axes[0, 0].set_ylabel("load at the tip [g]")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
    plt.close(figure)
    return figure
