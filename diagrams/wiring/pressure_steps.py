"""The input of a scenario, applied: pressures in steps, one source for every finger."""

from collections.abc import Iterable, Mapping

import numpy as np
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario import PressureConfig
from soft_gripper.signals import describe

COMMON = "all"


def pressure_steps(config: PressureConfig, finger: str) -> Array:
    """Pressure of a finger in every step, Pa, (steps,); a short list holds its last value."""
    steps = config.steps.get(finger, config.steps.get(COMMON))
    if steps is None:
        known = ", ".join(config.steps)
        raise InputError("pressure", "steps", known, f"give steps for finger '{finger}' or for '{COMMON}'")
    return np.concatenate([steps, np.full(max(map(len, config.steps.values())) - len(steps), steps[-1])])


def check_steps(config: PressureConfig, fingers: Iterable[str]) -> None:
    """Raises an InputError if there are steps for a finger that is none of `fingers`, by name."""
    known = [*fingers, COMMON]
    for name, steps in config.steps.items():
        if name not in known:
            raise InputError("pressure.steps", name, steps, f"no such finger; known: {', '.join(known)}")


def add_pressure_steps(
    builder: DiagramBuilder, steps: Mapping[str, Array], duration: float, commands: Mapping[str, InputPort]
) -> dict[str, OutputPort]:
    """Adds `{finger}.pressure_steps` for every command; returns the signals.

    `steps` are pressures by the names of the fingers, (steps,) Pa, each held for `duration` s.
    """
    signals = {}
    for finger, command in commands.items():
        source = builder.AddNamedSystem(f"{finger}.pressure_steps", step_source(steps[finger], duration))
        builder.Connect(source.get_output_port(), command)
        signals[f"{finger}.pressure_command"] = describe(source.get_output_port(), "Pa")
    return signals


def step_source(values: Array, duration: float) -> TrajectorySource:
    """A source of one value after the other, each held for `duration` s; the last one for ever."""
    times = np.arange(len(values) + 1) * duration
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(times, np.append(values, values[-1])[None, :]))
