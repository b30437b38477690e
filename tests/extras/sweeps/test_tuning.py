"""Tuning: the step response that it begins from, and what the optimization gains."""

from types import SimpleNamespace

import numpy as np
import pytest
from here_executor import HereExecutor

from soft_gripper.extras.sweeps import tuning
from soft_gripper.extras.sweeps.tuning import (
    UNSETTLED_COST,
    follow,
    gains_from_step_response,
    step_cost,
    step_response,
    tune,
)
from soft_gripper.runs.scores.steps import StepRow
from soft_gripper.scenario.scenario_file import load_scenario


@pytest.fixture(scope="module")
def two_steps():
    return load_scenario("tip_distance_steps", ["control.set_points=[0.06, 0.03]", "control.hold=2"])


def test_rise_time_is_that_of_the_finger_and_its_supply(two_steps):
    _, rise_time = step_response(two_steps)
    assert two_steps.pressure.time_constant < rise_time < 0.3
    slow = load_scenario("tip_distance_steps", ["pressure.time_constant=0.4"])
    assert step_response(slow)[1] == pytest.approx(0.4, abs=0.1)


@pytest.mark.slow
def test_tuning_lowers_the_cost(two_steps):
    costs = []
    best = tune(two_steps, HereExecutor(), 8, lambda gains, cost: costs.append(cost))
    assert len(costs) == 8
    cost = step_cost(follow(two_steps, best))
    assert cost == pytest.approx(np.min(costs))
    assert cost < 0.7 * costs[0]


def test_the_step_response_of_a_first_order_opening_is_its_gain_and_time_constant(monkeypatch):
    """The pressure steps as far as it may, less than it is tested with elsewhere."""
    time, time_constant, gain, most = np.arange(0, 4, 0.01), 0.2, -1e-6, 12e3
    opening = 0.09 + gain * most * (1 - np.exp(-time / time_constant))
    recording = SimpleNamespace(data={"time": SimpleNamespace(values=time)})
    stepped, made = [], tuning.make_private_station

    def make(scenario):
        stepped.append(scenario.pressure.steps)
        return made(scenario)

    monkeypatch.setattr(tuning, "make_private_station", make)
    monkeypatch.setattr(tuning, "run_station", lambda station, described: recording)
    monkeypatch.setattr(tuning, "true_opening", lambda station, recording: opening)
    found = step_response(load_scenario("tip_distance_steps", [f"pressure.maximum={most}"]))
    assert stepped[-1] == {"left_finger": [most], "right_finger": [most]}
    assert found[0] == pytest.approx(gain, rel=1e-6)
    assert found[1] == pytest.approx(time_constant, abs=0.011)


def test_the_first_integral_gain_closes_the_gap_in_five_rise_times():
    """Of a static gain with integral control: what is left falls as exp(-ki gain t)."""
    for gain, rise in ((-2e-6, 0.1), (3e-6, 0.4)):
        gains = gains_from_step_response(gain, rise)
        assert 1 / (gains.ki * abs(gain)) == pytest.approx(5 * rise)


def test_a_step_that_does_not_settle_costs_more_than_any_that_does():
    steps = [StepRow(0, 90, 80, 0.0, 0, settling, 0, 0) for settling in (0.4, float("nan"))]
    assert step_cost(steps) == pytest.approx((0.4 + UNSETTLED_COST) / 2)


def test_tuning_ends_with_the_best_gains_that_were_tried(monkeypatch):
    """The cost of a step is made up: how far the logarithms of the gains are from certain ones."""
    start = gains_from_step_response(-1e-6, 0.1)
    wanted = np.log([start.kp, start.ki, start.kd]) + np.array([0.4, 0.9, -0.3])

    def followed(_, gains):
        away = np.abs(np.log([gains.kp, gains.ki, gains.kd]) - wanted).sum()
        return [StepRow(0, 90, 80, 0.0, 0, float(away), 0, 0)]

    monkeypatch.setattr(tuning, "_response", lambda text: (-1e-6, 0.1))
    monkeypatch.setattr(tuning, "_follow", followed)
    costs = []
    best = tune(load_scenario("tip_distance_steps"), HereExecutor(), 60, lambda gains, cost: costs.append(cost))
    assert followed(None, best)[0].settling_s == pytest.approx(min(costs))
    assert min(costs) < 0.3 * costs[0]
