"""Prints tables to the terminal."""

import math
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple
from itertools import groupby
from operator import attrgetter
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.evaluation.paper.claims import Claim, verdict
from soft_gripper.hardware.identification.fit import Confidence, MotionScore
from soft_gripper.hardware.identification.free_parameters import FreeParameters
from soft_gripper.hardware.identification.identified_finger import Identified, Tested, doubts
from soft_gripper.hardware.identification.settled_states import IdentifiedStates, TestedStates
from soft_gripper.hardware.replay.held_out import ALL, ArmReplay, ReplayRow
from soft_gripper.placement.place_sensors import PlacedSensors
from soft_gripper.placement.placements import as_borders
from soft_gripper.placement.samples import Assumptions
from soft_gripper.placement.spatial_tables import VerifiedRow
from soft_gripper.placement.tables import LeftOutRow, PlacementRow
from soft_gripper.runs.scores.grasp import NEVER_TOUCHED
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.recorded_grasps import ObjectGrasp, ObjectGrip
from soft_gripper.runs.scores.steps import PhaseRow, StepRow
from soft_gripper.runs.trials.trial import Judged
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


_CORRELATED = 0.9


def print_identified(found: Tested) -> None:
    """Prints a line for each recording; of a fit first the parameters, with their confidence and correlations."""
    if isinstance(found, Identified):
        print(f"\nmarker error {100 * found.fit.root_mean_square:.2f} % of the largest displacement (root mean square)")
        _print_parameters(found.fit.free, found.fit.x, found.confidence)
        finger = found.model.finger
        remains = 1 - sum(branch.share for branch in finger.creep)
        if finger.creep:
            print(f"Young's modulus after all creep: {finger.base.youngs_modulus * remains:.5g} Pa")
        _print_correlations(found.fit.free, found.confidence)
    columns = {"recording": "", "role": "", "settled": ".2f", "motion": ".2f", "tip [%]": ".1f"}
    columns |= dict.fromkeys(("settled turn [degrees]", "creep [degrees]", "recovery [degrees]"), ">")
    columns |= dict.fromkeys(("50 % [ms]", "63 % [ms]"), ">")
    print_table(columns, map(_score_cells, found.scores), "marker errors [mm], and measured motion")
    for row in found.scores:
        if not np.isnan(row.frequency_hz + row.simulated_frequency_hz):
            swing = f"{row.frequency_hz:.2f} Hz ({row.simulated_frequency_hz:.2f})"
            print(f"{row.recording}: swings at {swing}, decrement {row.decrement:.2f} ({row.simulated_decrement:.2f})")
    for motion in found.motions:
        if motion.hold is not None:
            held = f"{1e3 * motion.hold.sag:.1f} mm low, turned by {np.degrees(motion.hold.turn):.1f} degrees"
            print(f"{motion.name}: held {held}")
    print("In brackets: simulated. Event times, and a held pose if it is free, are fitted to each recording, including")
    print("held-out ones. 50 and 63 %: times from the event to these shares of the settled turn.")
    for doubt in doubts(found):
        print(f"WARNING: {doubt}")


def print_identified_states(found: TestedStates) -> None:
    """Prints the errors of every recording and family, after the parameters, if any are fitted."""
    print()
    if isinstance(found, IdentifiedStates):
        _print_parameters(found.fit.free, found.fit.x, found.confidence)
        _print_correlations(found.fit.free, found.confidence)
    columns = {"recording": "", "role": "", "rows moved": "", "marker": "", "rows": "d"}
    columns |= {"root mean square": ".2f", "mean": ".2f", "95 %": ".2f"}
    print_table(columns, map(astuple, found.scores), "marker errors [mm], the mean offset removed")
    if isinstance(found, IdentifiedStates):
        print("Left out: predicted by a fit to the other families; each family has a mean offset of its own.")


def _print_parameters(free: FreeParameters, x: Array, confidence: Confidence) -> None:
    stds = confidence.std * np.where(free.is_positive, np.abs(free.values(x)), 1)
    fitted = zip(free.names, free.values(free.start), free.values(x), stds, free.units, strict=True)
    columns = {"parameter": "", "initial": ".5g", "fitted": ".5g", "standard deviation": ".2g", "": ""}
    print_table(columns, fitted)


def _print_correlations(free: FreeParameters, confidence: Confidence) -> None:
    names, correlation = free.names, confidence.correlation
    for i in range(len(names)):
        for j in range(i):
            if abs(correlation[i, j]) > _CORRELATED:
                print(f"correlated: {names[j]} and {names[i]} ({correlation[i, j]:+.3f})")
    for together in confidence.unresolved:
        what = " and ".join(together)
        says = "cannot be distinguished" if len(together) > 1 else "is hardly observable"
        print(f"{what} {says} in these recordings: fix one, or add recordings")


def _score_cells(row: MotionScore) -> list[str | float]:
    turn = f"{row.settled_turn_deg:.2f} ({row.simulated_settled_turn_deg:.2f})"
    creep = f"{row.creep_deg:.2f} ({row.simulated_creep_deg:.2f})"
    recovery = f"{row.recovery_deg:.2f} ({row.simulated_recovery_deg:.2f})"
    times = f"{row.t50_ms:.0f} ({row.simulated_t50_ms:.0f})", f"{row.t63_ms:.0f} ({row.simulated_t63_ms:.0f})"
    errors = row.settled_error_mm, row.motion_error_mm, row.tip_error_percent
    return [row.recording, row.role, *errors, turn, creep, recovery, *times]


def print_replay(replay: ArmReplay) -> None:
    """Prints which recordings each fit used, and a line for each estimator."""
    print("\nEach recording is estimated with a model fitted to others; its motion capture is used only for scoring:")
    for one in replay.replayed:
        creep = ", ".join(f"{branch.share:g} in {branch.time:g} s" for branch in one.fitted.arm.finger.creep)
        of_fit = f"creep {creep}; wires delayed by {1e3 * one.fitted.delay:.0f} ms"
        print(f"  {one.name:<12} fitted to {', '.join(one.fitted_on)} ({of_fit})")
        for beyond in one.extrapolated:
            print(f"WARNING: {one.name} is extrapolated: {beyond}")
    names = [name for name in dict.fromkeys(row.recording for row in replay.table) if name != ALL]
    for body in reversed(dict.fromkeys(row.body for row in replay.table)):
        rows = [row for row in replay.table if row.body == body]
        columns = {"": "", "mean": ".2f", "median": ".2f", "95 %": ".2f", "max": ".2f"}
        columns |= {"in band [%]": ".1f"} | {f"mean of {name}": ".2f" for name in names}
        cells = [_replay_cells(row, rows) for row in rows if row.recording == ALL]
        print_table(columns, cells, f"error of '{body}' [mm]")


def _replay_cells(row: ReplayRow, rows: Sequence[ReplayRow]) -> list[str | float]:
    numbers = row.mean_mm, row.median_mm, row.percentile_95_mm, row.max_mm, row.within_band_percent
    of_row = [other for other in rows if (other.estimator, other.sections) == (row.estimator, row.sections)]
    means = [other.mean_mm for other in of_row if other.recording != ALL]
    return [f"{row.estimator}, {row.sections} per side", *numbers, *means]


_BEST = 5  # placements to list


def print_ranking(rows: Sequence[PlacementRow], equal: int) -> None:
    """Prints the best placements, equal sections and the worst placement."""
    shown = sorted({*range(min(_BEST, len(rows))), equal, len(rows) - 1})
    columns = {"rank": "d", "borders": "", "pose error [mm]": ".3f"}
    if with_contacts := not math.isnan(rows[0].force_error_n):
        columns |= {"force [N]": ".3f", "place [mm]": ".1f", "missed [%]": ".1f"}
    cells = [astuple(rows[i])[: 6 if with_contacts else 3] for i in shown]
    marks = ["equal sections" if i == equal else "" for i in shown]
    print_table(columns | {"": ""}, [(*row, mark) for row, mark in zip(cells, marks, strict=True)])


def print_designs(rows: Sequence[VerifiedRow]) -> None:
    """Prints the best sensors in space of every number, with the errors predicted and, after a slash, made."""
    names = ("tip", "twist", "force", "place")
    columns = {"sensors": "d", "kind": "", "borders": ""} | dict.fromkeys(names, ">") | {"paths": ""}
    cells = []
    for row in rows:
        predicted = row.tip_mm, row.twist_deg, row.force_n, row.place_mm
        made = row.made_tip_mm, row.made_twist_deg, row.made_force_n, row.made_place_mm
        errors = [f"{p:.2g} / {m:.2g}" for p, m in zip(predicted, made, strict=True)]
        cells.append((row.sensors, row.kind, row.borders, *errors, row.paths))
    title = "errors predicted / made in statics: tip [mm], twist [degrees], force [N] and its place [mm]"
    print_table(columns, cells, title)


def print_left_out(rows: Sequence[LeftOutRow]) -> None:
    """Prints the gain of placed sensors on runs that were held out of the placement."""
    if rows:
        columns = {"": "", "borders": "", "equal": ".3f", "placed": ".3f", "better by [%]": ".1f"}
        title = "held-out runs (placed without the run that is scored), mean pose error [mm]:"
        print_table(columns, map(astuple, rows), title)


def print_snippet(placed: PlacedSensors, assumptions: Assumptions) -> None:
    """The part of a scenario that has the best placement, and an estimator with these assumptions."""
    borders = ", ".join(map(str, as_borders(placed.placements[0], placed.finger.segments)))
    assumed = assumptions.uncertainty
    print(f"\nsensor:\n  sections: {len(placed.placements[0]) + 1}")
    print(f"  borders: [{borders}]")
    print(f"estimator:\n  type: {assumptions.estimator}\n  uncertainty:")
    print(f"    reading: {assumed.reading:.2g}\n    bend_per_pressure: {assumed.bend_per_pressure:.2g}")
