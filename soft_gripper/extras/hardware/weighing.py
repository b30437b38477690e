"""The mass at the tip of a finger, weighed by the shape in which it rests: settled states of an identified finger.

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

The other part is what the fit leaves open. With C the covariance of its parameters, and G the changes of markers by
these,

    std(m)^2 = g' C g ,   g = G' J / (J' J) .

It includes the scale: modulus, density and stiffness of tendons may change in proportion without a change of shape,
unless a load is known. A single load that is small beside the finger's own weight leaves it open.

Both parts suppose that the model errs in a new shape as in the fitted ones. Where tendons are pulled otherwise, the
band is  sqrt(1 + growth^2 d)  times as wide, d being the mean distance of the rows from the nearest fitted pulled
lengths (`fitted_states`). The growth is learned in the fit (`learned_growth`), by leaving out regions of pulled lengths
under whatever load: it is such that the mass that is weighed there is within 95 % of these bands. A mass between fitted
ones is interpolated; by how much it is lighter or heavier than all of them counts in d as pulled lengths do.

With a recording of much the same motion without a load, the errors that the model makes in it where the tendons are
pulled most alike are taken from those of the loaded one, as a balance is tared: what is wrong in the model for both
cancels.

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
from soft_gripper.extras.hardware.identification.confidence import (
    UNOBSERVABLE,
    confidence_of,
    correlation_time,
    mean_correlation_time,
    square_root,
)
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.kept_confidence import ConfidenceConfig
from soft_gripper.extras.hardware.identification.model_band import are_far
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    SettledStates,
    by_rows,
    in_balance,
    marker_slopes,
    note_unbalanced,
    state_errors,
)
from soft_gripper.extras.hardware.left_out_regions import LeftOut, learned_widths, regions_left_out
from soft_gripper.files.document import require
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.sensors.fitted_states import FittedStates, spread_of

_NORMAL_95 = 1.96
_STEP = 0.02  # kg, of the finite differences
_STEPS = 4
_FEWEST_ROWS = 10  # rows of a window
_HALVES = (2, 4, 8)  # regions of equal numbers of rows, in which a mass is weighed without them
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


class Fitted(NamedTuple):
    """The fit of a finger, as it is kept."""

    states: FittedStatesConfig
    confidence: ConfidenceConfig


def weigh(
    model: Model, states: SettledStates, window: float, tare: SettledStates | None = None, fitted: Fitted | None = None
) -> list[Weighing]:
    """Weighs what hangs on the tip in every window of a recording, and in the last row over all of it.

    Args:
        model: the identified finger, without a load, in its set-up.
        states: of the recording; its own load is not looked at but named in the result.
        window: span of time, s; a rest of the recording that is shorter than half of one belongs to the last.
        tare: states without a load, in which tendons were pulled much as in this recording; None: there are none.
        fitted: what is kept of the fit; None: the finger is exact.

    Raises:
        InputError: if the rows have no times, those in which the finger finds a balance are too few for a window, or
            the fit is that of another finger.
    """
    require(window > 0, states.name, "--window", window, "give a span of time, s")
    offset = np.zeros(states.markers.shape) if tare is None else _errors_alike(model, tare, states)
    mass, error, slope = _linearised(model, states, offset)
    require(states.time is not None, states.name, "time", None, "the rows need times for windows")
    assert states.time is not None
    since = states.time - states.time[0]
    count = max(round(float(since[-1]) / window), 1)
    of_window = np.minimum((since / window).astype(int), count - 1)
    note_unbalanced(states, error + slope)
    known = in_balance(error + slope)
    at = replace(states, load=mass)
    is_far, apart, left_open = (
        (np.full(len(known), np.nan), np.zeros(len(known)), np.zeros((len(known), 0)))
        if fitted is None
        else _by_fit(fitted, model, at, slope)
    )
    found = []
    for rows in [*(known & (of_window == i) for i in range(count)), known]:
        expected = f"a window needs at least {_FEWEST_ROWS} rows: make it longer"
        require(int(rows.sum()) >= _FEWEST_ROWS, states.name, "--window", window, expected)
        away, band = _weighed(error[rows], slope[rows], left_open[rows])
        band *= float(np.sqrt(1 + apart[rows].mean()))
        begin, end = since[rows][[0, -1]]
        span = states.name, float(begin), float(end), int(rows.sum())
        far = 100 * float(is_far[rows].mean())
        found.append(Weighing(*span, 1e3 * (mass + away), 1e3 * band, far, 1e3 * states.load))
    return found


def _by_fit(fitted: Fitted, model: Model, states: SettledStates, slope: Array) -> tuple[Array, Array, Array]:
    """Of every row: whether it is far from what was fitted; growth^2 d, (R,); what the fit leaves open, (R, P)."""
    confidence, name = fitted.confidence, states.name
    free = confidence.free(model)
    expected = f"the finger has {len(free.names)} numbers of these keys: is it another one's?"
    require(len(free.names) == len(confidence.std), name, "confidence", len(confidence.std), expected)
    by_keys = marker_slopes(free, free.start, states, np.full(len(states.pulled), True))
    kept = fitted.states.fitted
    loads = kept.states[:, -1]
    beyond = abs(states.load - np.clip(states.load, loads.min(), loads.max())) / kept.spread[-1]
    distance = np.hypot(kept.part(slice(-1)).distance(states.pulled), beyond)
    apart = confidence.load_growth**2 * distance
    return are_far(fitted.states, states).astype(float), apart, _left_open(by_keys, confidence.covariance, slope)


def _left_open(by_keys: Array, covariance: Array, slope: Array) -> Array:
    """Contribution of each row to J' G R, (R, P): changes of the weighed mass by P independent unknowns, C = R R'.

    `by_keys` are derivatives of the markers by the parameters, (R M 3, P).
    """
    by_roots = by_keys @ square_root(covariance)
    left_open: Array = np.einsum("rmi,rmip->rp", np.nan_to_num(slope), by_roots.reshape(*slope.shape, -1))
    return left_open


def learned_growth(found: IdentifiedStates) -> float:
    """How the band of a weighed mass grows with the distance of pulled lengths; 0: no recording has a load.

    Learned to the first order, from fits without a region of pulled lengths, by the mass of each recording there.
    """
    fit, count = found.fit, len(found.left_out)
    states, errors = found.states[:count], found.errors[:count]
    if not any(of.load for of in states):
        return 0.0
    slope = np.concatenate([_by_mass(found.model, of, of.load)[1] for of in states])
    size, known = slope[0].size, in_balance(slope)
    residuals, by_keys = fit.residuals.reshape(slope.shape), fit.slopes.reshape(*slope.shape, -1)
    recording = np.repeat(np.arange(count), [len(of.pulled) for of in states])
    pulled = np.concatenate([of.pulled for of in states])
    shapes, last = (
        FittedStates(pulled, np.full(pulled.shape[1], spread_of(pulled))),
        mean_correlation_time(by_rows(errors)),
    )

    def without(region: NDArray[np.bool_]) -> LeftOut:
        kept = np.repeat(~region, size)
        moved = fit.change_without(kept, UNOBSERVABLE, fit.free.scales)
        covariance = confidence_of(fit.free, fit.x, fit.residuals[kept], fit.slopes[kept], last).covariance
        of_recordings = [np.flatnonzero(region & known & (recording == i)) for i in range(count)]
        weighed, distances = [], []
        for rows in [rows for rows in of_recordings if len(rows) >= _FEWEST_ROWS]:
            own, keys = _centred(slope[rows]), _centred(by_keys[rows])
            left_open = _left_open(keys.reshape(-1, len(moved)), covariance, own)
            weighed.append(_weighed(_centred(residuals[rows]) + keys @ moved, own, left_open))
            distances.append(shapes.without(region).distance(pulled[rows]).mean())
        away, band = np.array(weighed).reshape(-1, 2).T
        return LeftOut(np.abs(away / band)[:, None], np.sqrt(distances)[:, None])

    regions = [shapes.regions(), *(shapes.halves(most) for most in _HALVES)]
    left_out = tqdm(regions_left_out(regions, without), desc="bands of loads", unit="region", dynamic_ncols=True)
    return learned_widths(np.ones((1, 1)), [*left_out]).growth


def _centred(values: Array) -> Array:
    """Values of markers, (R, M, 3, ...), without their mean."""
    return values - values.mean(axis=(0, 1))


def _errors_alike(model: Model, tare: SettledStates, states: SettledStates) -> Array:
    """Errors of the unloaded model where tendons were pulled most as in each row, (R, M, 3) m."""
    error, pulled = state_errors(model, replace(tare, load=0.0)), cKDTree(tare.pulled)
    apart, nearest = pulled.query(states.pulled)
    reach = float(np.ptp(tare.pulled, axis=0).max())
    expected = (
        f"pulls no tendons as this recording does: rows are {100 * _PULL_TOLERANCE:.0f} % of the range apart, or more"
    )
    require(float(np.median(apart)) <= _PULL_TOLERANCE * reach, states.name, "--tare", tare.name, expected)
    return error[nearest]


def _linearised(model: Model, states: SettledStates, offset: Array) -> tuple[float, Array, Array]:
    """The mass at which a finger agrees best, or 0; errors of the markers, and their slopes by the mass, (R, M, 3).

    `offset` are errors that the model makes without a load, (R, M, 3) m; they are taken from these.
    """
    mass = 0.0
    for _ in range(_STEPS):
        error, slope = _by_mass(model, states, mass)
        error = error - offset
        before, mass = mass, max(mass - float(np.nansum(slope * error) / np.nansum(slope**2)), 0.0)
    return before, error, slope


def _by_mass(model: Model, states: SettledStates, mass: float) -> tuple[Array, Array]:
    """Errors of the markers under a mass at the tip, kg, and their slopes by it, (R, M, 3)."""
    error, more = (state_errors(model, replace(states, load=m)) for m in (mass, mass + _STEP))
    return error, (more - error) / _STEP


def _weighed(error: Array, slope: Array, left_open: Array) -> tuple[float, float]:
    """Change of the mass with which rows agree best, and its band, kg, of which `left_open`, (R, P), has a part."""
    strength = float((slope**2).sum())
    away = -float((slope * error).sum()) / strength
    sums = (slope * (error + slope * away)).sum(axis=(1, 2))
    variance = len(sums) * sums.var() * correlation_time(sums) + (left_open.sum(axis=0) ** 2).sum()
    return away, _NORMAL_95 * float(np.sqrt(variance)) / strength


def weighing_figure(weighings: Sequence[Weighing]) -> Figure:
    """Plots the mass in every window with its band, and what the file's name says, a panel for each recording."""
    names = list(dict.fromkeys(row.recording for row in weighings))
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(
            1, len(names), figsize=(1.2 + 2.6 * len(names), 2.8), sharey=True, squeeze=False, constrained_layout=True
        )
        for panel, name in zip(axes[0], names, strict=True):
            *windows, whole = [row for row in weighings if row.recording == name]
            middles = [(row.begin_s + row.end_s) / 2 for row in windows]
            panel.errorbar(
                middles,
                [row.load_g for row in windows],
                [row.band_g for row in windows],
                fmt="o",
                ms=4,
                capsize=3,
                color=ESTIMATOR_COLORS[5],
                label="estimated, 95 %",
            )
            panel.axhline(whole.named_g, color="0.35", lw=1, ls="--", label="hung on the tip")
            panel.set(title=name, xlabel="time [s]", xlim=(0, None))
        axes[0, 0].set_ylabel("load at the tip [g]")
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2, frameon=False)
    plt.close(figure)
    return figure
