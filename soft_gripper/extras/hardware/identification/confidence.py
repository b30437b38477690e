"""The accuracy of fitted parameters: standard deviations, correlations, and parameters that cannot be determined.

With the Jacobian J of the residuals by the parameters and s^2 their variance, the covariance is  s^2 (J^T J)^-1  if
residuals were independent. Those of an inexact model are correlated in time. The variance therefore includes their
correlation time,  1 + 2 sum of autocorrelations , up to the first that is not positive.

Parameters that change the residuals alike are not determined beside each other. Of such a group the one that was named
last keeps the value at which the search ended, where the others are optimal, and the rest is looked at again without
it: what is said of them holds for that value.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.identification.free_parameters import FreeParameters

_INDISTINGUISHABLE = 0.98  # correlation above which two parameters cannot be distinguished
UNOBSERVABLE = 1e-3  # of the strongest: a direction that changes the residuals less is unobservable
_NOTHING = 1e-12  # if even the strongest change of the residuals is smaller, it is rounding
_TAKES_PART = 0.2  # of the largest part in an unobservable direction, beyond which a parameter takes part


class Undetermined(NamedTuple):
    """A parameter that recordings do not determine, and that keeps a value."""

    name: str
    value: float
    unit: str
    beside: tuple[str, ...]  # the parameters it cannot be told apart from; none: it hardly changes anything
    correlation: float  # with that parameter, if it is one; else NaN

    def __str__(self) -> str:
        of_two = "" if np.isnan(self.correlation) else f" (correlation {self.correlation:+.4f})"
        beside = f" beside {', '.join(self.beside)}{of_two}" if self.beside else ": it hardly changes anything"
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"dropped {self.name}, which is not determined{beside}; kept at {self.value:.5g}{unit}"


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
    """The confidence in a vector (P,) that follows from its residuals and their Jacobian.

    Args:
        free: the parameters.
        x: their values.
        residuals: (R,).
        jacobian: (R, P).
        lasting: number of samples over which residuals are correlated.
    """
    names, units, values = free.names, free.units, free.values(x)
    by_changes, left, dropped = jacobian * free.scales, list(range(len(names))), list[Undetermined]()
    of_all, _ = _covariance(by_changes)
    while True:
        covariance, groups = _covariance(by_changes[:, left])
        if not groups:
            break
        group, correlation = groups[0]
        *beside, last = [left[i] for i in group]
        undetermined = Undetermined(
            names[last], float(values[last]), units[last], tuple(names[i] for i in beside), correlation
        )
        dropped.append(undetermined)
        left.remove(last)
    variance = np.sum(residuals**2) / max(len(residuals) - len(left), 1) * lasting
    spread = np.sqrt(np.diag(covariance))
    std = np.sqrt(variance) * spread * free.scales[left]
    of_all = variance * of_all * np.outer(free.scales, free.scales)
    return Confidence([names[i] for i in left], std, covariance / np.outer(spread, spread), tuple(dropped), of_all)


_Group = tuple[Sequence[int], float]  # indices in their order, and the correlation of a pair


def _covariance(jacobian: Array) -> tuple[Array, list[_Group]]:
    """Covariance by residuals of variance 1, (P, P); parameters that it does not tell apart, the most alike first."""
    if not jacobian.shape[1]:
        return np.zeros((0, 0)), []
    _, strengths, directions = np.linalg.svd(jacobian, full_matrices=False)
    least = max(UNOBSERVABLE * strengths[0], _NOTHING)
    covariance = (directions.T / np.maximum(strengths, least) ** 2) @ directions
    spread = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(spread, spread)
    groups: list[_Group] = []
    for direction in directions[strengths <= least][::-1]:
        part = np.flatnonzero(np.abs(direction) > _TAKES_PART * np.abs(direction).max())
        groups.append((part.tolist(), float(correlation[part[0], part[1]]) if len(part) == 2 else np.nan))
    above = np.triu(np.abs(correlation), 1)
    pairs = np.argwhere(above > _INDISTINGUISHABLE)
    pairs = pairs[np.argsort(-above[tuple(pairs.T)])]
    groups += [((int(i), int(j)), float(correlation[i, j])) for i, j in pairs]
    return covariance, groups


def square_root(covariance: Array) -> Array:
    """R of a covariance R R', (P, P): a column for the deviation of each independent unknown."""
    sizes, directions = np.linalg.eigh(covariance)
    root: Array = directions * np.sqrt(np.maximum(sizes, 0.0))
    return root


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
