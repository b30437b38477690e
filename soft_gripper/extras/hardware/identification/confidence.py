"""The accuracy of fitted parameters: standard deviations, correlations, and parameters that cannot be determined.

With the Jacobian J of the residuals by the parameters and s^2 their variance, the covariance is  s^2 (J^T J)^-1  if
residuals were independent. Those of an inexact model are correlated in time. The variance therefore includes their
correlation time,  1 + 2 sum of autocorrelations , up to the first that is not positive.

Parameters that change the residuals alike are not determined beside each other. Of such a group the one that was named
last keeps the value at which the search ended, where the others are optimal, and the rest is looked at again without
it: what is said of them holds for that value.

The confidence is kept beside the file of an identified finger. What is estimated with the finger is as uncertain as its
parameters: by their covariance C, and the change g of the estimate by each, its variance is  g^T C g . Parameters that
recordings do not determine take part with their large variance, so that an estimate that depends on them says so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.identification.companion_file import CompanionFile
from soft_gripper.extras.hardware.identification.free_parameters import (
    PRESSURE_LAW,
    FingerFit,
    FreeParameters,
    Model,
    free_parameters,
)
from soft_gripper.quantity import Violation, quantity

_MAX_CORRELATION = 0.98  # correlation above which two parameters cannot be distinguished
UNOBSERVABLE = 1e-3  # of the strongest: a direction that changes the residuals less is unobservable
_ROUNDING = 1e-12  # if even the strongest change of the residuals is smaller, it is rounding
_MIN_PART_SHARE = 0.2  # of the largest part in an unobservable direction, beyond which a parameter takes part
_BOUND_DISTANCE = 0.02  # typical changes, within which a value is at an end of its range
_DIGITS, _MIN_NUMBER = 5, 1e-9  # of kept numbers; smaller ones are rounding


class Undetermined(NamedTuple):
    """A parameter that recordings do not determine, and that keeps a value."""

    name: str
    value: float
    unit: str
    beside: tuple[str, ...]  # the parameters it cannot be told apart from; none: it hardly changes anything
    correlation: float  # with that parameter, if it is one; else NaN

    def __str__(self) -> str:
        correlation = "" if np.isnan(self.correlation) else f" (correlation {self.correlation:+.4f})"
        pair_text = f" beside {', '.join(self.beside)}{correlation}" if self.beside else ": it hardly changes anything"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"dropped {self.name}, which is not determined{pair_text}; kept at {self.value:.5g}{unit}"


@dataclass(frozen=True)
class Confidence:
    """The confidence of the P parameters that are determined, of F that were fitted."""

    names: list[str]
    std: Array  # (P,) of the vector: of logarithms if these were fitted
    correlation: Array  # (P, P)
    undetermined: tuple[Undetermined, ...]
    covariance: Array  # (F, F) of the vector, of all that were fitted: large where something is not determined

    def std_of(self, name: str) -> float:
        """Standard deviation of a parameter; NaN if it is not determined."""
        return float(self.std[self.names.index(name)]) if name in self.names else np.nan


def confidence_of(free: FreeParameters, x: Array, residuals: Array, jacobian: Array, lasting: float) -> Confidence:
    """Confidence in a vector (P,), from its residuals, (R,), and their Jacobian, (R, P).

    `lasting` is the number of samples over which residuals are correlated.
    """
    names, units, values = free.names, free.units, free.values(x)
    slopes, kept_indices, undetermined = jacobian * free.scales, list(range(len(names))), list[Undetermined]()
    whole_covariance, _ = _covariance(slopes)
    while True:
        covariance, groups = _covariance(slopes[:, kept_indices])
        if not groups:
            break
        group, correlation = groups[0]
        *other_indices, last = [kept_indices[i] for i in group]
        other_names = tuple(names[i] for i in other_indices)
        undetermined.append(Undetermined(names[last], float(values[last]), units[last], other_names, correlation))
        kept_indices.remove(last)
    variance = np.sum(residuals**2) / max(len(residuals) - len(kept_indices), 1) * lasting
    std = np.sqrt(variance) * np.sqrt(np.diag(covariance)) * free.scales[kept_indices]
    whole_covariance = variance * whole_covariance * np.outer(free.scales, free.scales)
    names = [names[i] for i in kept_indices]
    return Confidence(names, std, _correlation(covariance), tuple(undetermined), whole_covariance)


def fit_doubts(fit: FingerFit[Any], confidence: Confidence) -> list[str]:
    """Warnings about keys that are undetermined or at a bound, and about a search that ended before it converged."""
    free, x, (lower_bounds, upper_bounds) = fit.free, fit.x, fit.free.bounds
    is_at_end = np.minimum(x - lower_bounds, upper_bounds - x) < _BOUND_DISTANCE * free.scales
    doubts = [
        f"{name} ends at {value:.3g}, a bound of its range: fix it, or try --starts 5"
        for name, value in zip(np.array(free.names)[is_at_end], free.values(x)[is_at_end], strict=True)
        if name in confidence.names
    ]
    if not confidence.names:
        doubts = ["no key is determined: the values at which the search ended predict what is left out, too"]
    if not fit.converged:
        doubts += ["the search was ended before it converged: go on from the finger that it wrote, or free fewer keys"]
    return doubts


_Group = tuple[Sequence[int], float]  # indices in their order, and the correlation of a pair


def _covariance(jacobian: Array) -> tuple[Array, list[_Group]]:
    """Covariance for residuals of variance 1, (P, P), and groups of indistinguishable parameters, most alike first."""
    if not jacobian.shape[1]:
        return np.zeros((0, 0)), []
    _, strengths, directions = np.linalg.svd(jacobian, full_matrices=False)
    min_strength = max(UNOBSERVABLE * strengths[0], _ROUNDING)
    covariance = (directions.T / np.maximum(strengths, min_strength) ** 2) @ directions
    correlation = _correlation(covariance)
    groups: list[_Group] = []
    for direction in directions[strengths <= min_strength][::-1]:
        indices = np.flatnonzero(np.abs(direction) > _MIN_PART_SHARE * np.abs(direction).max())
        groups.append((indices.tolist(), float(correlation[indices[0], indices[1]]) if len(indices) == 2 else np.nan))
    upper_correlation = np.triu(np.abs(correlation), 1)
    pairs = np.argwhere(upper_correlation > _MAX_CORRELATION)
    pairs = pairs[np.argsort(-upper_correlation[tuple(pairs.T)])]
    groups += [((int(i), int(j)), float(correlation[i, j])) for i, j in pairs]
    return covariance, groups


def _correlation(covariance: Array) -> Array:
    stds = np.sqrt(np.diag(covariance))
    return covariance / np.outer(stds, stds)


def square_root(covariance: Array) -> Array:
    """R of a covariance R R', (P, P): a column for the deviation of each independent unknown."""
    sizes, directions = np.linalg.eigh(covariance)
    return directions * np.sqrt(np.maximum(sizes, 0.0))


def mean_correlation_time(series: Sequence[Array]) -> float:
    """Mean correlation time of the columns of some series, (T, K) each, that are not constant, in samples."""
    times = [correlation_time(column) for columns in series for column in columns.T if np.ptp(column) > 0]
    return float(np.mean(times)) if times else 1.0


def correlation_time(series: Array) -> float:
    """1 + 2 sum of autocorrelations, in samples, at least 1."""
    centred = series - series.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlations = np.fft.irfft(spectrum)[: len(centred)]
    correlations = correlations / correlations[0]
    ends = np.flatnonzero(correlations <= 0)
    return float(1 + 2 * correlations[1 : ends[0] if len(ends) else None].sum())


@dataclass
class ConfidenceConfig:
    """Standard deviations and correlations of P fitted numbers."""

    keys: list[str] = quantity([], filled=True)  # that were free
    std: list[float] = quantity([], least=0, filled=True)  # of every number; of logarithms where these were fitted
    correlation: list[list[float]] = quantity([], least=-1.001, most=1.001, filled=True)
    # Of the band of a weighed load, by the root of the distance from the fitted pulled lengths; 0: it does not grow
    load_growth: float = quantity(0.0, least=0)

    def violations(self) -> Iterator[Violation]:
        count = len(self.std)
        if [len(row) for row in self.correlation] != [count] * count:
            shape = f"{len(self.correlation)} rows"
            yield "correlation", shape, f"must be {count} rows of {count} numbers, one for every deviation"

    @property
    def covariance(self) -> Array:
        """Covariance of the vector of the free parameters, (P, P)."""
        return np.array(self.correlation) * np.outer(self.std, self.std)

    def parameters(self, model: Model) -> FreeParameters:
        """The parameters of a finger in its set-up whose confidence this is."""
        names = dict.fromkeys(PRESSURE_LAW if key.startswith(PRESSURE_LAW) else key for key in self.keys)
        law_numbers = sum(key.startswith(PRESSURE_LAW) for key in self.keys)  # gain, and margin
        pressures = [model.setup.highest_pressure / (1 + number) for number in range(law_numbers)]
        return free_parameters(model.finger, [*names], pressures, model.setup)


CONFIDENCE = CompanionFile(
    ".confidence.yaml",
    "How well the fitted numbers of a finger are known, for bands and `soft-gripper weigh`",
    ConfidenceConfig,
)


def kept_confidence(free: FreeParameters, confidence: Confidence, load_growth: float = 0.0) -> ConfidenceConfig:
    """Fields of the file with the confidence of a fit."""
    std = np.sqrt(np.diag(confidence.covariance))
    unit = np.where(std > 0, std, 1.0)
    rounded_rows = [[_round(value) for value in row] for row in confidence.covariance / np.outer(unit, unit)]
    return ConfidenceConfig(list(free.keys), [_round(value) for value in std], rounded_rows, _round(load_growth))


def _round(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}") if abs(value) > _MIN_NUMBER else 0.0
