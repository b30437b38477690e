"""Prints results of runs to the terminal: grasps, slips, phases and truth."""

import math
import textwrap
from collections.abc import Callable, Sequence
from itertools import groupby
from operator import attrgetter

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.files.row_table import UNKNOWN, headings, print_rows, print_table
from soft_gripper.runs.scores.grasp import HELD, NEVER_TOUCHED, RESTING
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.recorded_grasps import ObjectGrasp, ObjectGrip
from soft_gripper.runs.scores.recorded_slips import ObjectSlip
from soft_gripper.runs.scores.recorded_task import Judged
from soft_gripper.runs.scores.steps import PhaseRow
from soft_gripper.scenario.schema import TaskConfig


def print_poses(rows: Sequence[PoseRow]) -> None:
    """Prints a line for each steady state, with its pressure or, unless all fingers have one chamber, its number."""
    has_pressures = all(math.isfinite(row.pressure_kpa) for row in rows)
    leaves_plane = any(row.sideways_angle_deg or row.twist_angle_deg for row in rows)
    turns = ["bend_angle_deg", *(["sideways_angle_deg", "twist_angle_deg"] if leaves_plane else [])]
    names = [*(["pressure_kpa"] if has_pressures else []), *turns, "pose_error_mm", "tip_error_mm"]
    steps = {} if has_pressures else {"step": "d"}
    cells = [
        [row.finger, *([] if has_pressures else [step]), *(getattr(row, name) for name in names)]
        for _, finger_rows in groupby(rows, attrgetter("finger"))
        for step, row in enumerate(finger_rows, 1)
    ]
    print_table({"finger": "", **steps, **headings(PoseRow, names)}, cells)


def print_truth(row: Judged) -> None:
    """Prints the ground truth of a task: where the object ended up."""
    squeeze = "" if np.isnan(row.squeeze_mm) else f", squeezed by up to {row.squeeze_mm:.2f} mm"
    _print_sentence(
        f"Ground truth: {row.placed_error_mm:.1f} mm and {row.placed_angle_deg:.1f} degrees from the goal,"
        f" slip in the fingers {row.slip_mm:.1f} mm, normal force of a finger up to {row.peak_force_n:.2f} N{squeeze}"
    )


_SENTENCE_WIDTH = 76  # columns, as many as code blocks of the pages have


def _print_sentence(text: str) -> None:
    print(textwrap.fill(text, _SENTENCE_WIDTH, subsequent_indent="  ", break_long_words=False, break_on_hyphens=False))


def print_grasps(grasps: Sequence[ObjectGrasp], grips: Sequence[ObjectGrip], instead: str = "") -> None:
    """Prints how each object is held: a line for each finger, and a line on the whole grasp.

    `instead` is what the fingers touch that is no object, in words, for objects that they never touch.
    """
    for grasp in grasps:
        if grasp.grasp == NEVER_TOUCHED:
            print()
            _print_sentence(f"Grasp of {grasp.object}: {grasp.grasp}{instead and f'; {instead}'}")
            continue
        object_grips = [grip for grip in grips if grip.object == grasp.object]
        print_rows(object_grips, f"Grasp of {grasp.object}: {grasp.grasp}", leave=("object",))
        if not math.isnan(grasp.slip_ratio):
            _print_sentence(
                f"It slips below {grasp.least_force_n:.2f} N of {grasp.normal_force_n:.2f} N ({grasp.slip_ratio:.0%})"
                f"{_motion(grasp)}"
            )
        if grasp.grasp in (HELD, RESTING):
            _print_sentence(
                f"Width: {_amount(grasp.true_width_mm, '.1f', 'mm')}; stiffness, estimated:"
                f" {_amount(grasp.estimated_stiffness_n_m, '.0f', 'N/m')}"
            )
        print(f"Work of the pump: {grasp.pump_energy_mj:.1f} mJ")


def _motion(grasp: ObjectGrasp) -> str:
    """Sentence on the motion of an object while it was held; "" if it was not."""
    if math.isnan(grasp.moved_mm):
        return ""
    return (
        f"; while held it has slid {_amount(grasp.slid_mm, '.2f', 'mm')} on the fingers, moved {grasp.moved_mm:.2f} mm"
        f" and turned {grasp.turned_deg:.2f} degrees in the palm, {grasp.sideways_play_mm:.2f} mm of that sideways"
    )


def _amount(value: float, form: str, unit: str) -> str:
    return UNKNOWN if math.isnan(value) else f"{value:{form}} {unit}"


def print_slips(slips: Sequence[ObjectSlip]) -> None:
    """Prints whether each object could be expected to be held, and why it slips."""
    for slip in slips:
        if slip.predicted:
            takes = f"its weight takes {slip.weight_share:.0%} of the friction available"
            _print_sentence(f"Before {slip.object} is lifted, {takes}: it {slip.predicted}")
        loss = "" if math.isnan(slip.lost_s) else f"is lost at {slip.lost_s:.2f} s"
        if not math.isnan(slip.slips_s):
            phase = f" in '{slip.slips_in}'" if slip.slips_in else ""
            _print_sentence(
                f"{slip.object} slips from {slip.slips_s:.2f} s{phase} on {slip.slips_on}{loss and f', and {loss}'}"
            )
            if math.isnan(slip.used_share):
                print("  The fingers did not grip it before")
            else:
                use = f"  Before, {slip.used_share:.0%} of the friction available was used."
                _print_sentence(f"{use} {_would_have_held(slip)}")
        elif loss:
            print(f"{slip.object} {loss}, and does not slide before")


def _would_have_held(slip: ObjectSlip) -> str:
    """The force or friction that would have held an object that slips, in words."""
    if slip.needed_force_n <= slip.present_force_n:
        return "The fingers could carry its weight: a motion or a turn took it out of them"
    remedy = f": models.{slip.object}.friction of {slip.least_object_friction:.2f}"
    return (
        f"Its weight takes {slip.needed_force_n:.2f} N a finger ({slip.present_force_n:.2f} N then), or a coefficient"
        f" of friction of {slip.least_friction:.2f} ({slip.present_friction:.2f} here)"
        f"{remedy if math.isfinite(slip.least_object_friction) else ''}"
    )


def print_phases(rows: Sequence[PhaseRow], outcome: Outcome, task: TaskConfig, lost: Sequence[str] = ()) -> None:
    """Prints a line for each phase of a task, and its outcome, beside which objects are not held in truth."""
    print_rows(rows, "Phases, with the opening, the torque and the pressure at the end of each")
    timeout = f", not finished after {task.time_limit:g} s (task.time_limit)" if outcome == Outcome.RUNNING else ""
    truth = f"; in truth: {', '.join(lost)}" if lost else ""
    print(f"\nOutcome, as estimated: {outcome.words}{timeout}{truth}")


def changes_line(finger: str, read: Callable[[str], Array]) -> str:
    """Changes that `recursive` has found of a finger, see `recursive.Changes`; `read` reads a signal by its name."""
    bend, std = (100 * float(np.ravel(read(f"{finger}.{name}"))[0]) for name in ("bend_change", "bend_change_std"))
    offsets, stds = (np.ravel(read(f"{finger}.{name}")) for name in ("offset_changes", "offset_changes_std"))
    largest = int(np.abs(offsets).argmax())
    offset_text = f"offsets have moved by up to {offsets[largest]:+.2g} +- {stds[largest]:.2g}"
    return f"{finger}: bends {bend:+.1f} +- {std:.1f} % further than its model; {offset_text}"
