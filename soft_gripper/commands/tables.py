"""Prints tables to the terminal."""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np

from soft_gripper.control.task import Outcome
from soft_gripper.evaluation.paper.claims import Claim, verdict
from soft_gripper.runs.scores.grasp import NEVER_TOUCHED
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.recorded_grasps import ObjectGrasp, ObjectGrip
from soft_gripper.runs.scores.recorded_task import Judged
from soft_gripper.runs.scores.steps import PhaseRow, StepRow
from soft_gripper.scenario.schema import TaskConfig


def print_table(columns: Mapping[str, str], rows: Iterable[Sequence[Any]], title: str = "") -> None:
    """Prints rows of cells below the names of their columns.

    Args:
        columns: format specification of each column, by column name; "": text, aligned left.
        rows: cells in the order of the columns.
        title: a line printed above the table.
    """
    texts = [[format(cell, form) for cell, form in zip(row, columns.values(), strict=True)] for row in rows]
    widths = [max(map(len, cells)) for cells in zip(columns, *texts, strict=True)]
    print(f"\n{title}" if title else "")
    for line in (list(columns), *texts):
        cells = zip(line, widths, columns.values(), strict=True)
        print("  ".join(f"{text:{'>' if form else '<'}{width}}" for text, width, form in cells).rstrip())


def print_poses(rows: Sequence[PoseRow]) -> None:
    """Prints a line for each steady state, with its pressure or, unless all fingers have one chamber, its number."""
    has_pressures = all(map(math.isfinite, (row.pressure_kpa for row in rows)))
    columns = {"finger": ""} | ({"pressure [kPa]": ".1f"} if has_pressures else {"step": "d"})
    turns = {"bend [degrees]": attrgetter("bend_angle_deg")}
    if any(row.sideways_angle_deg or row.twist_angle_deg for row in rows):
        turns["sideways [degrees]"] = attrgetter("sideways_angle_deg")
        turns["twist [degrees]"] = attrgetter("twist_angle_deg")
    columns |= dict.fromkeys(turns, ".2f") | {"pose error [mm]": ".3f", "fingertip error [mm]": ".3f"}
    cells = [
        (
            *(r.finger, r.pressure_kpa if has_pressures else step),
            *(turn(r) for turn in turns.values()),
            *(r.pose_error_mm, r.tip_error_mm),
        )
        for _, of_finger in groupby(rows, attrgetter("finger"))
        for step, r in enumerate(of_finger, 1)
    ]
    print_table(columns, cells)


def print_steps(rows: Sequence[StepRow]) -> None:
    """Prints a line for each step of the gripper opening."""
    columns = {"step": "d", "from [mm]": ".1f", "to [mm]": ".1f", "overshoot [%]": ".2f", "settling [s]": ".2f"}
    columns |= {"steady error [mm]: estimated": ".4f", "true": ".3f"}
    shown = attrgetter("step", "from_mm", "to_mm", "overshoot_percent", "settling_s")
    steady = attrgetter("steady_error_estimated_mm", "steady_error_true_mm")
    print_table(columns, ([*shown(row), *steady(row)] for row in rows))


def print_truth(row: Judged) -> None:
    """Prints the ground truth of a task: where the object ended up."""
    squeezed = "" if np.isnan(row.squeeze_mm) else f", squeezed by up to {row.squeeze_mm:.2f} mm"
    print(
        f"Ground truth: {row.placed_error_mm:.1f} mm and {row.placed_angle_deg:.1f} degrees from the goal,"
        f" slip in the fingers {row.slip_mm:.1f} mm, normal force of a finger up to {row.peak_force_n:.2f} N{squeezed}"
    )


def print_grasps(grasps: Sequence[ObjectGrasp], grips: Sequence[ObjectGrip]) -> None:
    """Prints how each object is held: a line for each finger, and a line on the whole grasp."""
    columns = {"finger": "", "normal force [N]": ".3f", "friction force [N]": ".3f", "area [mm^2]": ".1f"}
    columns |= {"mean pressure [kPa]": ".1f", "largest pressure [kPa]": ".1f", "largest impulse [mN s]": ".1f"}
    for grasp in grasps:
        rows = [astuple(grip)[1:] for grip in grips if grip.object == grasp.object]
        if grasp.grasp == NEVER_TOUCHED:
            print(f"\nGrasp of {grasp.object}: {grasp.grasp}")
            continue
        print_table(columns, rows, f"Grasp of {grasp.object}: {grasp.grasp}")
        if not math.isnan(grasp.slip_ratio):
            print(
                f"It slips below {grasp.least_force_n:.2f} N of {grasp.normal_force_n:.2f} N ({grasp.slip_ratio:.0%});"
                f" while held it has slid {grasp.slid_mm:.2f} mm on the fingers,\nmoved {grasp.moved_mm:.2f} mm and"
                f" turned {grasp.turned_deg:.2f} degrees in the palm, {grasp.sideways_play_mm:.2f} mm of that sideways"
            )
        if not math.isnan(grasp.estimated_width_mm):
            print(
                f"As estimated, it is {grasp.estimated_width_mm:.1f} mm wide, with a stiffness of"
                f" {grasp.estimated_stiffness_n_m:.0f} N/m"
            )
        print(f"Work of the pump: {grasp.pump_energy_mj:.1f} mJ")


def print_phases(rows: Sequence[PhaseRow], outcome: Outcome, task: TaskConfig) -> None:
    """Prints a line for each phase of a task, and its outcome."""
    columns = {"phase": "", "began [s]": ".2f", "lasted [s]": ".2f"}
    columns |= {"at its end: opening [mm]": ".1f", "torque [mN m]": ".1f", "pressure [kPa]": ".1f"}
    print_table(columns, map(astuple, rows))
    late = f", not finished after {task.time_limit:g} s (task.time_limit)" if outcome == Outcome.RUNNING else ""
    print(f"\nOutcome, as estimated: {outcome.words}{late}")


def print_claims(claims: Sequence[Claim]) -> None:
    """Prints a line for each claim, with our result, and how many claims fail."""
    width = max(len(claim.text) for claim in claims)
    print(f"\n{'claim':<{width}}  by     here")
    for claim in claims:
        word = "holds" if claim.holds else _red("FAILS")
        print(f"{claim.text:<{width}}  {claim.source:<6} {word}: {claim.number}")
    summary = verdict(claims)
    print("\n" + (summary if all(claim.holds for claim in claims) else _red(summary)))


def _red(text: str) -> str:
    """Colours text red on a terminal; a file or a pipe gets plain text."""
    return f"\033[31m{text}\033[0m" if sys.stdout.isatty() else text
