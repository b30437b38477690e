"""The table of robustness: errors of every estimator, with sensors that err and beliefs that are wrong."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from soft_gripper.estimators.uncertainty import uncertainty_of
from soft_gripper.evaluation.paper.scenario_run import SECTIONS
from soft_gripper.evaluation.robustness.plants import FingerAtRest
from soft_gripper.evaluation.robustness.sample_errors import Errors, estimated, in_mm, together
from soft_gripper.runs.scores.readings import with_sections
from soft_gripper.scenario.belief import read_belief
from soft_gripper.scenario.scenario import BelievedConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors
from soft_gripper.sensors.strain_errors import StrainErrors

PRESET = "realistic"
NOISES = (0.0, 1.0, 2.0, 4.0)  # times the errors of the preset
_SIZES = ("creep", "hysteresis", "gain_error", "offset", "drift", "low_frequency_noise", "noise")


@dataclass(frozen=True)
class Belief:
    """By which shares what is believed differs from the truth."""

    modulus: float = 0.0  # of Young's modulus of the silicone
    pressure: float = 0.0  # of the measured pressure

    @property
    def name(self) -> str:
        """In tables."""
        parts = ("E", self.modulus), ("p", self.pressure)
        return ", ".join(f"{what} {100 * share:+.0f} %" for what, share in parts if share) or "as simulated"

    @property
    def size(self) -> float:
        """Of both together: the share by which the bend per pressure may be wrong."""
        return float(np.hypot(self.modulus, self.pressure))

    @property
    def config(self) -> BelievedConfig:
        """As a scenario says it."""
        change = None if self.modulus == 0 else f"{100 * self.modulus:+g} %"
        return BelievedConfig(youngs_modulus=change)


# Too soft a finger and too high a pressure both promise too much bend: the signs are those that add up.
BELIEFS = (Belief(), Belief(-0.1, 0.01), Belief(0.1, -0.01))


def errors_at(noise: float) -> StrainErrors | None:
    """The errors of sensors that err so many times as much as the preset; None without."""
    preset = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=PRESET)))
    if preset is None or noise == 0:
        return None
    return replace(preset, **{name: noise * getattr(preset, name) for name in _SIZES})


Key = tuple[str, str, int]  # estimator, belief, sections


@dataclass(frozen=True)
class RobustnessRow:
    """Of all touched fingers, held samples and seeds together."""

    scenario: str
    estimator: str
    belief: str
    noise: float  # times the errors of the preset
    sections: int
    mean_mm: float
    p95_mm: float  # 95th percentile
    worst_mm: float
    coverage: float  # share of places in their 95 % bands; NaN for an estimator that gives no covariance
    seeds: int


def robustness_table(
    name: str,
    fingers: Sequence[FingerAtRest],
    noise: float,
    seeds: int,
    estimators: Sequence[str],
    beliefs: Sequence[Belief] = BELIEFS,
) -> list[RobustnessRow]:
    """A row for every belief, number of sections and estimator, in this order, at one noise.

    Without noise all seeds would be the same, and one serves.
    """
    found: dict[Key, list[Errors]] = defaultdict(list)
    for finger in fingers:
        for key, errors in _errors(finger, noise, seeds if noise else 1, estimators, beliefs):
            found[key].append(errors)
    return [
        RobustnessRow(name, estimator, belief, noise, sections, *in_mm(together(parts)), seeds)
        for (estimator, belief, sections), parts in found.items()
    ]


def _errors(
    held: FingerAtRest, noise: float, seeds: int, estimators: Sequence[str], beliefs: Sequence[Belief]
) -> Iterator[tuple[Key, Errors]]:
    errors, sensor = errors_at(noise), held.station.scenario.sensor
    readings = {sections: held.readings(sections, errors, seeds) for sections in SECTIONS}
    for belief in beliefs:
        believed = read_belief(belief.config).layout(held.simulated, sensor)
        uncertainty = uncertainty_of(errors, None, belief.size)
        for sections in SECTIONS:
            layout = with_sections(believed, sections)
            for estimator in estimators:
                found = estimated(estimator, layout, uncertainty, held, readings[sections], 1 + belief.pressure)
                yield (estimator, belief.name, sections), found
