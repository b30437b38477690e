"""Gains for the grip control of a gripper: first from a step response, then by optimization in simulation."""

from collections.abc import Callable, Mapping
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import minimize

from soft_gripper.arrays import Array
from soft_gripper.control.pid_controller import PidGains
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.wiring.drive import PATH_SEPARATOR
from soft_gripper.diagrams.wiring.grip_control import allocation
from soft_gripper.runs.scores.steps import StepRow, step_table, true_opening
from soft_gripper.scenario.scenario_file import dump_scenario, parse_scenario
from soft_gripper.scenario.schema import Scenario

ALLOWED_OVERSHOOT = 2.0  # percent
TEST_PRESSURE = 30e3  # Pa
TEST_SHARE = 0.1  # of the largest command of tendons
UNSETTLED_COST = 10.0  # s, cost of a step that does not settle
_TEXT_NAME = Path("scenario.yaml")  # name for the text of a scenario in messages

Report = Callable[[PidGains, float], None]


def step_response(scenario: Scenario) -> tuple[float, float]:
    """Gain and rise time (63 %), s, of the opening after a step from 0 in pressure, or in the command of tendons.

    The gain is in m/Pa, or in m/N or m/m of tendons.
    """
    scenario = replace(scenario, control=replace(scenario.control, set_points=None))
    fingers = make_private_station(scenario).fingers
    steps = replace(scenario.pressure, settle=2.0, hold_samples=1)
    if any(finger.finger.pressures for finger in fingers):
        step = min(TEST_PRESSURE, scenario.pressure.maximum)
        shares = {f.name: (f.finger.chamber_axis, f.finger.pressure_gains) for f in fingers}
        scenario = replace(scenario, pressure=replace(steps, steps=_steps(shares, step)))
    else:
        step = TEST_SHARE * (scenario.tendons.maximum or 0.0)
        shares = {f.name: (f.finger.tendon_axis, f.finger.tension_gains) for f in fingers}
        scenario = replace(scenario, pressure=steps, tendons=replace(scenario.tendons, steps=_steps(shares, step)))
    station = make_private_station(scenario)
    recording = run_station(station, described=False)
    change = true_opening(station, recording)
    change = change - change[0]
    rise_index = np.flatnonzero(np.abs(change) > 0.63 * abs(change[-1]))[0]
    return float(change[-1]) / step, float(recording.data["time"].values[rise_index])


def _steps(
    drives: Mapping[str, tuple[Mapping[str, list[str]], Mapping[str, Array]]], step: float
) -> dict[str, list[float]]:
    """Distributes a step of the common grip command among chambers or tendons, as steps of a scenario.

    `drives` gives for each finger the labels of these, if there are several, and their gains.
    """
    steps: dict[str, list[float]] = {}
    for finger, (axis, gains) in drives.items():
        shares = np.maximum(allocation(gains["bending"].sum(axis=-1)), 0.0)
        names = [f"{finger}{PATH_SEPARATOR}{name}" for names in axis.values() for name in names] or [finger]
        steps |= {name: [step * float(share)] for name, share in zip(names, shares, strict=True)}
    return steps


def gains_from_step_response(gain: float, rise_time: float) -> PidGains:
    """A slow integral controller, a safe initial guess: it removes the error in about five rise times."""
    return PidGains(kp=0.1 / abs(gain), ki=0.2 / (abs(gain) * rise_time), kd=0.01 * rise_time / abs(gain))


def tune(scenario: Scenario, executor: Executor, evaluations: int = 60, report: Report | None = None) -> PidGains:
    """Gains that bring the gripper opening to its set points fastest, with hardly any overshoot.

    Args:
        scenario: a closed-loop scenario, whose set points are followed.
        executor: runs the simulations, one at a time.
        evaluations: maximum number of simulations.
        report: called with the gains and the cost of each simulation.
    """
    text = dump_scenario(scenario)
    start = gains_from_step_response(*executor.submit(_response, text).result())

    def cost(logarithms: Array) -> float:
        gains = replace(start, **dict(zip(("kp", "ki", "kd"), map(float, np.exp(logarithms)), strict=True)))
        value = step_cost(executor.submit(_follow, text, gains).result())
        if report is not None:
            report(gains, value)
        return value

    begin = np.log([start.kp, start.ki, start.kd])
    simplex = np.vstack([begin, begin + 0.5 * np.eye(3)])
    options = {"maxfev": evaluations, "initial_simplex": simplex, "xatol": 0.01, "fatol": 1e-3}
    best = minimize(cost, begin, method="Nelder-Mead", options=options)
    return replace(start, **dict(zip(("kp", "ki", "kd"), map(float, np.exp(best.x)), strict=True)))


def _response(text: str) -> tuple[float, float]:
    return step_response(parse_scenario(_TEXT_NAME, text))


def _follow(text: str, gains: PidGains) -> list[StepRow]:
    return follow(parse_scenario(_TEXT_NAME, text), gains)


def follow(scenario: Scenario, gains: PidGains) -> list[StepRow]:
    """The step rows of the closed loop for the set points of the scenario, with these gains."""
    station = make_private_station(replace(scenario, control=replace(scenario.control, gains=gains)))
    return step_table(station, run_station(station, described=False))


def step_cost(rows: list[StepRow]) -> float:
    """Mean settling time, s, plus 0.1 s per percent of overshoot above the allowed value."""
    excess = (max(0.0, row.overshoot_percent - ALLOWED_OVERSHOOT) for row in rows)
    settling = (UNSETTLED_COST if np.isnan(row.settling_s) else row.settling_s for row in rows)
    return float(np.mean([time + 0.1 * overshoot for time, overshoot in zip(settling, excess, strict=True)]))
