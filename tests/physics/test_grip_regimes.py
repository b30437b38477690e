"""The paper's regimes of the grip control at a step of the opening: one rings, one is well damped, one creeps."""

from itertools import pairwise

import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.runs.scores.steps import StepRow, step_table
from soft_gripper.scenario.scenario_file import load_scenario

SHIPPED = load_scenario("tip_distance_steps").control


def largest_step() -> list[float]:
    """The set points before and after the largest step of the scenario."""
    points = SHIPPED.set_points
    return max(([a, b] for a, b in pairwise(points)), key=lambda step: abs(step[1] - step[0]))


def with_integral_gain(factor: float) -> StepRow:
    """How the opening follows that step with a multiple of the shipped integral gain."""
    changes = [f"control.set_points={largest_step()}", f"control.gains.ki={factor * SHIPPED.gains.ki}"]
    station = make_station(load_scenario("tip_distance_steps", changes))
    return step_table(station, run_station(station))[-1]


@pytest.mark.slow
def test_the_first_rings_the_second_is_well_damped_and_the_third_creeps() -> None:
    """Of the rings at least two lie beyond the set point and two before it; all settle, the shipped gains soonest."""
    ringing, shipped, creeping = map(with_integral_gain, (3.0, 1.0, 0.3))
    assert ringing.overshoot_percent > 30
    assert ringing.crossings >= 4
    assert shipped.overshoot_percent < 5
    assert shipped.crossings <= 1
    assert creeping.overshoot_percent == 0
    assert creeping.crossings == 0
    assert ringing.settling_s > 1.5 * shipped.settling_s
    assert creeping.settling_s > 2 * shipped.settling_s
