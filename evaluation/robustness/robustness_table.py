"""The table of robustness: errors of every estimator, with sensors that err and beliefs that are wrong."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from soft_gripper.diagrams.wiring.belief import believed_layout
from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.evaluation.paper.readings_again import with_sections
from soft_gripper.evaluation.paper.scenario_run import SECTIONS
from soft_gripper.evaluation.robustness.cases import BELIEFS, Belief, errors_at
from soft_gripper.evaluation.robustness.finger_at_rest import FingerAtRest
from soft_gripper.evaluation.robustness.sample_errors import Errors, estimated, in_mm, together
from soft_gripper.shape.sensor_uncertainty import uncertainty_of

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
    name: str, fingers: Sequence[FingerAtRest], noise: float, seeds: int, beliefs: Sequence[Belief] = BELIEFS
) -> list[RobustnessRow]:
    """A row for every belief, number of sections and estimator, in this order, at one noise.

    Without noise all seeds would be the same, and one serves.
    """
    found: dict[Key, list[Errors]] = defaultdict(list)
    for finger in fingers:
        for key, errors in _errors(finger, noise, seeds if noise else 1, beliefs):
            found[key].append(errors)
    return [
        RobustnessRow(name, estimator, belief, noise, sections, *in_mm(together(parts)), seeds)
        for (estimator, belief, sections), parts in found.items()
    ]


def _errors(held: FingerAtRest, noise: float, seeds: int, beliefs: Sequence[Belief]) -> Iterator[tuple[Key, Errors]]:
    errors, sensor = errors_at(noise), held.station.scenario.sensor
    readings = {sections: held.readings(sections, errors, seeds) for sections in SECTIONS}
    for belief in beliefs:
        believed = believed_layout(held.simulated, sensor, belief.config)
        uncertainty = uncertainty_of(errors, None, belief.size)
        for sections in SECTIONS:
            layout = with_sections(believed, sections)
            for estimator in SHAPE_FUNCTIONS:
                found = estimated(estimator, layout, uncertainty, held, readings[sections], 1 + belief.pressure)
                yield (estimator, belief.name, sections), found
