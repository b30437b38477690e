"""Grasps that are simulated once and repeated for an hour: the finger closes on an object, holds it, and opens again.

Half of them press on a peg anywhere along the finger, half of them hold a box, each at a pressure of its own. A grasp
begins and ends with an open finger at rest, so that one can follow any other.
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
_NEAREST, _FURTHEST, _GAP = 0.35, 0.97, 6e-3  # shares of the length; m, between finger and peg at the tip, at most
_FACE, _TOP = -0.0245, 0.2  # m, in the world, of a peg that touches, and of the base


class Grasps(NamedTuple):
    """A finger during T samples."""

    q: Array  # (T, N) rad
    pressure: Array  # (T) Pa
    gravity: Array  # (T, 3) m/s^2 in B
    force: Array  # (T) N, true, absolute; NaN or 0 without contact


def simulated_grasp(seed: int, number: int, repeated: int = 1) -> Grasps:
    """A grasp of a set of grasps; or the same several times one after the other, in one simulation."""
    return grasps_of(simulate(changed_scenario(*_drawn(np.random.default_rng([seed, number]), number, repeated))))


def grasps_of(recording: Recording) -> Grasps:
    """The motion of the finger of a recording, every PERIOD."""

    def of(name: str) -> Array:
        return recording.samples(f"{FINGER}.{name}")[:: round(PERIOD / _SIMULATED)]

    gravity = to_base(of("X_WB"), np.array([0.0, 0.0, -G]))
    force = np.abs(of("true_contact_force")).reshape(-1)
    return Grasps(of("sampled_joint_angles"), of("sampled_pressure").reshape(-1), gravity, force)


def _drawn(rng: np.random.Generator, number: int, repeated: int) -> tuple[str, dict[str, Any]]:
    """The scenario of a grasp, and changes to it."""
    pressure, share = rng.uniform(*_PRESSURES), rng.uniform(_NEAREST, _FURTHEST)
    steps = repeated * [*HELD_STEPS * [pressure], *OPEN_STEPS * [0.0]]
    held = {"pressure.settle": STEP - 0.1, "pressure.hold_samples": 10}
    if number % 2:
        return "box_grasp", held | {"pressure.steps": {"all": steps}}
    place = [_FACE + _GAP * share * rng.uniform(), 0, _TOP - share * read_finger().length]
    changes = {"pressure.steps": {"all": [0.0], FINGER: steps}, "models.1.X_PC.translation": place}
    return "obstructed_inside", held | changes


def repeated(grasps: list[Grasps], order: NDArray[np.int_]) -> Grasps:
    """Grasps one after the other, by their numbers."""
    return Grasps(*(np.concatenate([part[i] for i in order]) for part in zip(*grasps, strict=True)))
