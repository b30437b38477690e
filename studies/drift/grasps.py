"""Grasps that are simulated once and repeated for an hour: the finger closes on an object, holds it, and opens again.

In: seed and number of a grasp. Out: its `Grasps`. Half of them press on a peg anywhere along the finger, half of them
hold a box, at random pressures. A grasp begins and ends with an open finger at rest, so that one can follow any other.
Another kind of grasp is a branch of `_random_changes`.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.plane import to_base
from soft_gripper.scenario.scenario_file import changed_scenario
from studies.contacts.contacts import G, read_finger

PERIOD = 0.1  # s, between samples of the sensors
STEP, HELD_STEPS, OPEN_STEPS = 2.0, 4, 2  # s, of pressure steps, and how many of them
GRASP = STEP * (HELD_STEPS + OPEN_STEPS)  # s
FINGER = "left_finger"
_SIMULATED = 0.01  # s, between recorded samples
_PRESSURES = 60e3, 150e3  # Pa
_NEAREST, _FURTHEST, _GAP = 0.35, 0.97, 6e-3  # fractions of the length; m, between finger and peg at the tip, at most
_FACE, _TOP = -0.0245, 0.2  # m, in the world, of a peg that touches, and of the base


class Grasps(NamedTuple):
    """A finger during T samples."""

    q: Array  # (T, N) rad
    pressure: Array  # (T) Pa
    gravity: Array  # (T, 3) m/s^2 in B
    force: Array  # (T) N, true, transverse; NaN or 0 without contact


def simulated_grasp(seed: int, number: int, times: int = 1) -> Grasps:
    """A grasp of a set of grasps; or the same several times one after the other, in one simulation."""
    scenario = changed_scenario(*_random_changes(np.random.default_rng([seed, number]), number, times))
    return finger_grasps(simulate(scenario))


def finger_grasps(recording: Recording) -> Grasps:
    """The motion of the finger of a recording, every PERIOD."""

    def samples(name: str) -> Array:
        return recording.samples(f"{FINGER}.{name}")[:: round(PERIOD / _SIMULATED)]

    gravity = to_base(samples("X_WB"), np.array([0.0, 0.0, -G]))
    force = samples("true_transverse_force").reshape(-1)
    return Grasps(samples("sampled_joint_angles"), samples("sampled_pressure").reshape(-1), gravity, force)


def _random_changes(rng: np.random.Generator, number: int, times: int) -> tuple[str, dict[str, Any]]:
    """The scenario of a grasp, and changes to it."""
    pressure, fraction = rng.uniform(*_PRESSURES), rng.uniform(_NEAREST, _FURTHEST)
    steps = times * [*HELD_STEPS * [pressure], *OPEN_STEPS * [0.0]]
    durations = {"pressure.settle": STEP - 0.1, "pressure.hold_samples": 10}
    if number % 2:
        return "box_grasp", durations | {"pressure.steps": {"all": steps}}
    position = [_FACE + _GAP * fraction * rng.uniform(), 0, _TOP - fraction * read_finger().length]
    changes = {"pressure.steps": {"all": [0.0], FINGER: steps}, "models.1.X_PC.translation": position}
    return "obstructed_inside", durations | changes


def join_grasps(grasps: list[Grasps], order: NDArray[np.int_]) -> Grasps:
    """Grasps one after the other, by their numbers."""
    return Grasps(*(np.concatenate([part[i] for i in order]) for part in zip(*grasps, strict=True)))
