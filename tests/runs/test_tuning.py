"""Tuning: the step response that it begins from, and what the optimization gains."""

import numpy as np
import pytest
from here_executor import HereExecutor

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.runs.scores.steps import StepRow
from soft_gripper.runs.tuning import follow, gains_from_step_response, step_cost, step_response, tune
from soft_gripper.scenario.scenario_file import load_scenario


@pytest.fixture(scope="module")
def two_steps():
    return load_scenario("tip_distance_steps", ["control.set_points=[0.06, 0.03]", "control.hold=2"])


def test_step_response_has_the_gain_of_the_settled_finger(two_steps):
    gain, _ = step_response(two_steps)
    assert gain < 0, "pressure closes the gripper"
    # Another way to the same gain: the closed loop's pressure for a known change of the opening.
    recording = simulate(two_steps)
    travel = recording["grip.opening"].values[-1] - recording["grip.opening"].values[0]
    assert gain == pytest.approx(travel / recording["left_finger.pressure"].values[-1], rel=0.05)


def test_rise_time_is_that_of_the_finger_and_its_supply(two_steps):
    _, rise_time = step_response(two_steps)
    assert two_steps.pressure.time_constant < rise_time < 0.3
    slow = load_scenario("tip_distance_steps", ["pressure.time_constant=0.4"])
    assert step_response(slow)[1] == pytest.approx(0.4, abs=0.1)


def test_first_gains_are_stable(two_steps):
    gains = gains_from_step_response(*step_response(two_steps))
    assert min(gains.kp, gains.ki, gains.kd) > 0
    assert all(abs(row.steady_error_estimated_mm) < 1 for row in follow(two_steps, gains))


def test_cost_counts_overshoot_beyond_two_percent():
    table = [StepRow(0, 90, 80, overshoot, 0, settling, 0, 0) for overshoot, settling in ((1.9, 0.5), (5.0, 0.7))]
    assert step_cost(table) == pytest.approx(0.6 + 0.3 / 2)


@pytest.mark.slow
def test_tuning_lowers_the_cost(two_steps):
    costs = []
    best = tune(two_steps, HereExecutor(), 8, lambda gains, cost: costs.append(cost))
    assert len(costs) == 8
    cost = step_cost(follow(two_steps, best))
    assert cost == pytest.approx(np.min(costs))
    assert cost < 0.7 * costs[0]
