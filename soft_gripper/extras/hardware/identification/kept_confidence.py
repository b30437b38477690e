"""The confidence of fitted parameters, kept beside the file of an identified finger and read again with it.

What is estimated with the finger is as uncertain as its parameters: by their covariance C, and the change g of the
estimate by each, its variance is  g^T C g . Parameters that recordings do not determine take part with their large
variance, so that an estimate that depends on them says so.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.identification.beside_finger import BesideFinger
from soft_gripper.extras.hardware.identification.confidence import Confidence
from soft_gripper.extras.hardware.identification.free_parameters import (
    PRESSURE_LAW,
    FreeParameters,
    Model,
    free_parameters,
)
from soft_gripper.quantity import Violation, quantity

_DIGITS = 5
_NOTHING = 1e-9  # smaller numbers are rounding


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

    def free(self, model: Model) -> FreeParameters:
        """The parameters of a finger in its set-up whose confidence this is."""
        names = dict.fromkeys(PRESSURE_LAW if key.startswith(PRESSURE_LAW) else key for key in self.keys)
        of_law = sum(key.startswith(PRESSURE_LAW) for key in self.keys)  # gain, and margin
        pressures = [model.setup.highest_pressure / (1 + number) for number in range(of_law)]
        return free_parameters(model.finger, [*names], pressures, model.setup)


CONFIDENCE = BesideFinger(
    ".confidence.yaml",
    "How well the fitted numbers of a finger are known, for bands and `soft-gripper weigh`",
    ConfidenceConfig,
)


def kept_confidence(free: FreeParameters, confidence: Confidence, load_growth: float = 0.0) -> ConfidenceConfig:
    """The confidence of a fit, as its file has it."""
    std = np.sqrt(np.diag(confidence.covariance))
    unit = np.where(std > 0, std, 1.0)
    rounded = [[_rounded(value) for value in row] for row in confidence.covariance / np.outer(unit, unit)]
    return ConfidenceConfig(list(free.keys), [_rounded(value) for value in std], rounded, _rounded(load_growth))


def _rounded(value: float) -> float:
    return float(f"{value:.{_DIGITS}g}") if abs(value) > _NOTHING else 0.0
