"""The input of a scenario: pressures in steps, one source for every finger."""

import numpy as np
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.errors import InputError

COMMON = "all"


def pressure_steps(scenario: Scenario, finger: str) -> Array:
    """Pressure of a finger in every step of the scenario, Pa, (steps,); a short list holds its last value."""
    steps = scenario.pressure.steps.get(finger, scenario.pressure.steps.get(COMMON))
    if steps is None:
        known = ", ".join(scenario.pressure.steps)
        raise InputError("pressure", "steps", known, f"give steps for finger '{finger}' or for '{COMMON}'")
    return np.concatenate([steps, np.full(scenario.steps - len(steps), steps[-1])])


def pressure_source(scenario: Scenario, finger: str) -> TrajectorySource:
    """A source of the pressure of one finger, (1) Pa."""
    steps = pressure_steps(scenario, finger)
    times = np.arange(len(steps) + 1) * scenario.step_duration
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, np.append(steps, steps[-1])[None, :]))
