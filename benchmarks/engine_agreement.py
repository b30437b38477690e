"""Every shipped scenario in MuJoCo and in Drake: where the tips rest, how hard the fingers press, and how it ends.

    python benchmarks/engine_agreement.py [SCENARIO ...]

prints a table; a row is also printed to stderr as soon as it is known. MuJoCo has contact at points, so that it is also
compared with Drake with `contact: points`: what differs less there is due to the model of contact, not to the engine.
Tips and forces are compared at the end of each step of pressure or set point, and of a task at the end of the first
phase that holds the object; forces are means over the last half second before, and differences of smaller forces than
0.5 N are shares of 0.5 N. What differs in the whole force, but not in the normal force, is friction.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import Run, run_many
from soft_gripper.errors import InputError, shortened
from soft_gripper.files.row_table import print_rows
from soft_gripper.runs.scores.recorded_grasps import recorded_grasps
from soft_gripper.runs.scores.steps import outcome
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import DRAKE
from soft_gripper.scenario.shipped import scenario_names

LAST = 50  # samples before the end of a step
LEAST = 0.5  # N, of which a difference of force is a share at least


@dataclass(frozen=True)
class Agreement:
    """How a scenario in MuJoCo agrees with Drake; worst of all fingers and steps."""

    scenario: str
    tips_mm: Annotated[float, ".2f"]
    force_percent: Annotated[float, ".1f"]
    normal_force_percent: Annotated[float, ".1f"]
    tips_mm_with_points: Annotated[float, ".2f"]
    force_percent_with_points: Annotated[float, ".1f"]
    normal_force_percent_with_points: Annotated[float, ".1f"]
    in_drake: str
    in_mujoco: str
    step: str


def ends(run: Run) -> list[int]:
    """The samples that are compared."""
    scenario, task, samples = run.station.scenario, run.station.task, run.recording["time"].values
    if task is not None:
        holding = [number for number, phase in enumerate(task.phases) if phase.holds][:1]
        held = np.flatnonzero(np.isin(run.recording["task.phase"].values, holding))
        return [int(held[-1]) if len(held) else len(samples) - 1]
    times = scenario.step_duration * np.arange(1, scenario.steps + 1)
    return [int(np.searchsorted(samples, each + 1e-9)) - 1 for each in times]


def tips_at_rest(run: Run) -> Array:
    """Tips at the ends of K steps, (F, K, 3) m."""
    rows, fingers = ends(run), run.station.fingers
    return np.array([run.recording[f"{finger.name}.true_tip_position"].values[rows] for finger in fingers])


def forces_at_rest(run: Run, signal: str) -> Array:
    """A signal of forces at the ends of K steps, (F, K) N."""
    forces = [run.recording[f"{finger.name}.{signal}"].values.ravel() for finger in run.station.fingers]
    return np.array([[force[max(0, row - LAST) : row + 1].mean() for row in ends(run)] for force in forces])


def words(run: Run) -> str:
    """How a run ends."""
    grasps = [grasp.grasp for grasp in recorded_grasps(run.station, run.recording)[0]]
    return ", ".join([*grasps, *([] if run.station.task is None else [outcome(run.recording).words])]) or "-"


def run_with(name: str, **changes: str) -> Run:
    """A run of a shipped scenario with changes."""
    (run,) = run_many([changed_scenario(name, changes)])
    if isinstance(run, Exception):
        raise run
    return run


def agreement(name: str) -> Agreement:
    """How a shipped scenario agrees."""
    one, other = run_with(name, engine="mujoco"), run_with(name, engine=DRAKE)
    with_points = run_with(name, engine=DRAKE, contact="points")
    step = str(one.recording.data.attrs["engine_step"]).partition(";")[0]
    return Agreement(name, *apart(one, other), *apart(one, with_points), words(other), words(one), step)


def apart(one: Run, other: Run) -> tuple[float, float, float]:
    """How far tips of two runs are apart, mm, and how much forces and normal forces differ, percent of the other."""
    shift = float(np.linalg.norm(tips_at_rest(one) - tips_at_rest(other), axis=-1).max())
    shares = []
    for signal in ("true_contact_total", "normal_force"):
        forces, there = forces_at_rest(one, signal), forces_at_rest(other, signal)
        shares.append(float((np.abs(forces - there) / np.maximum(there, LEAST)).max()))
    return 1e3 * shift, 100 * shares[0], 100 * shares[1]


def main(names: Sequence[str]) -> None:
    """Prints the table."""
    rows = []
    for name in names:
        try:
            rows.append(agreement(name))
            print(rows[-1], file=sys.stderr, flush=True)
        except InputError as error:
            print(f"{name}: {shortened(str(error), 200)}")
    print_rows(rows)


if __name__ == "__main__":
    main(sys.argv[1:] or scenario_names())
