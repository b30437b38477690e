"""Every shipped scenario in MuJoCo and in Drake: where the tips rest, how hard the fingers press, and how it ends.

    python benchmarks/engine_agreement.py [SCENARIO ...]

writes docs/extras/mujoco_engine/agreement.csv, each row as soon as it is known, and puts the table into the page
beside it. Rows of other scenarios are kept. MuJoCo has contact at points, so that it is also
compared with Drake with `contact: points`: what differs less there is due to the model of contact, not to the engine.
Tips and forces are compared at the end of each step of pressure or set point, and of a task at the end of the first
phase that holds the object; forces are means over the last half second before, and differences of smaller forces than
0.5 N are shares of 0.5 N. What differs in the whole force, but not in the normal force, is friction.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import Run, run_many
from soft_gripper.errors import InputError, shortened
from soft_gripper.files.row_table import read_csv, write_csv
from soft_gripper.runs.scores.recorded_grasps import recorded_grasps
from soft_gripper.runs.scores.steps import outcome
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import DRAKE
from soft_gripper.scenario.shipped import scenario_names

TABLE, PAGE = (
    Path(__file__).parents[1] / "docs/extras/mujoco_engine" / name for name in ("agreement.csv", "mujoco.md")
)
HEADING = (
    "| scenario | tips [mm] | at points | force [%] | at points | normal force [%] | in Drake | in MuJoCo | step |",
    "|---|---:|---:|---:|---:|---:|---|---|---:|",
)
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


def page_table(rows: Sequence[Agreement]) -> list[str]:
    """The lines of the table of the page: all scenarios that touch something."""
    lines = [
        f"| `{row.scenario}` | {row.tips_mm:.2f} | {row.tips_mm_with_points:.2f} | {row.force_percent:.1f}"
        f" | {row.force_percent_with_points:.1f} | {row.normal_force_percent:.1f}"
        f" | {row.in_drake} | {row.in_mujoco} | {row.step} |"
        for row in rows
        if row.force_percent > 0
    ]
    return [*HEADING, *lines]


def write_page(rows: Sequence[Agreement]) -> None:
    """Puts the table in the place of the one that the page has."""
    lines = PAGE.read_text(encoding="utf-8").splitlines()
    start = lines.index(HEADING[0])
    end = next(number for number in range(start, len(lines)) if not lines[number].startswith("|"))
    lines[start:end] = page_table(rows)
    PAGE.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main(names: Sequence[str]) -> None:
    """Writes the table."""
    rows = {row.scenario: row for row in read_csv(TABLE, Agreement)} if TABLE.is_file() else {}
    for name in names:
        try:
            rows[name] = agreement(name)
        except InputError as error:
            print(f"{name}: {shortened(str(error), 200)}")
            continue
        print(rows[name], flush=True)
        write_csv(TABLE, [rows[each] for each in sorted(rows)])
    write_page([rows[each] for each in sorted(rows)])


if __name__ == "__main__":
    main(sys.argv[1:] or scenario_names())
