"""How well fitted parameters are known: standard deviations, correlations, and what cannot be told apart.

With the Jacobian J of the residuals by the parameters and s^2 their variance, the covariance is  s^2 (J^T J)^-1  were
residuals independent. Those of a simulation that is not quite the hardware last: samples that follow each other say the
same. So the variance counts the time over which they last,  1 + 2 sum of autocorrelations , up to the first that is not
positive.
"""

from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.evaluation.identify.fit import Fit

_ALIKE = 0.98  # correlation, from which on two parameters are not told apart
_FLAT = 1e-3  # of the strongest: a direction in which the residuals change less is not seen at all
_NOTHING = 1e-12  # a change of the residuals that is rounding, were it the strongest


class Confidence(NamedTuple):
    """Of P parameters."""

    std: Array  # (P,) of the vector: of logarithms where these were fitted
    correlation: Array  # (P, P)
    unresolved: list[tuple[str, ...]]  # names of parameters that cannot be told apart


def confidence(fit: Fit) -> Confidence:
    """What the residuals and the Jacobian of a fit say."""
    jacobian, names = fit.jacobian * fit.free.scales, fit.free.names
    _, strengths, directions = np.linalg.svd(jacobian, full_matrices=False)
    least = max(_FLAT * strengths[0], _NOTHING)
    variance = np.sum(fit.residuals**2) / max(len(fit.residuals) - len(names), 1) * _lasting(fit)
    covariance = (directions.T / np.maximum(strengths, least) ** 2) @ directions
    spread = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(spread, spread)
    std = np.sqrt(variance) * spread * fit.free.scales
    return Confidence(std, correlation, _unresolved(names, correlation, directions[strengths <= least]))


def _unresolved(names: list[str], correlation: Array, flat: Array) -> list[tuple[str, ...]]:
    """Pairs that are next to fully correlated, and all that takes part in a direction that nothing shows."""
    pairs = [(i, j) for i in range(len(names)) for j in range(i) if abs(correlation[i, j]) > _ALIKE]
    found: set[tuple[str, ...]] = {(names[j], names[i]) for i, j in pairs}
    for direction in flat:
        part = np.abs(direction) > 0.2 * np.abs(direction).max()
        found.add(tuple(name for name, is_part in zip(names, part, strict=True) if is_part))
    return sorted(found)


def _lasting(fit: Fit) -> float:
    """For how many samples the residuals of the recordings last, in the mean, at least 1."""
    lasting, begin = [], 0
    for motion in fit.motions:
        samples, markers = motion.markers.shape
        part = fit.residuals[begin : begin + 2 * samples * markers].reshape(samples, -1)
        begin += part.size
        lasting += [_correlation_time(column) for column in part.T if np.ptp(column) > 0]
    return float(np.mean(lasting)) if lasting else 1.0


def _correlation_time(series: Array) -> float:
    centred = series - series.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * len(centred))) ** 2
    correlations = np.fft.irfft(spectrum)[: len(centred)]
    correlations = correlations / correlations[0]
    ends = np.flatnonzero(correlations <= 0)
    return float(1 + 2 * correlations[1 : ends[0] if len(ends) else None].sum())
