"""The input of a scenario: pressures in steps, one source for every finger."""

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
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


def add_pressure_steps(
    builder: DiagramBuilder, scenario: Scenario, commands: Mapping[str, InputPort]
) -> dict[str, OutputPort]:
    """Adds `{finger}.pressure_steps` for every command; returns the signals."""
    signals = {}
    for finger, command in commands.items():
        source = step_source(pressure_steps(scenario, finger), scenario.step_duration)
        builder.AddNamedSystem(f"{finger}.pressure_steps", source)
        builder.Connect(source.get_output_port(), command)
        signals[f"{finger}.pressure_command"] = source.get_output_port()
    return signals


def step_source(values: Array, duration: float) -> TrajectorySource:
    """A source of one value after the other, each held for `duration` s; the last one for ever."""
    times = np.arange(len(values) + 1) * duration
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, np.append(values, values[-1])[None, :]))
