"""Tables on the terminal."""

import math
import sys
from collections.abc import Sequence

import numpy as np

from soft_gripper.control.task_phases import Outcome
from soft_gripper.evaluation.paper.claims import Claim, verdict
from soft_gripper.hardware.identification.identification import Identified
from soft_gripper.hardware.identification.motion_scores import MotionScore
from soft_gripper.hardware.replay.recordings import ALL, Replayed, ReplayRow
from soft_gripper.placement.assumptions import Assumptions
from soft_gripper.placement.place_sensors import PlacedSensors
from soft_gripper.placement.placements import as_borders
from soft_gripper.placement.tables import LeftOutRow, PlacementRow
from soft_gripper.runs.scores.phases import PhaseRow
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.steps import StepRow
from soft_gripper.runs.trials.trial import Judged
from soft_gripper.scenario.scenario import TaskConfig


def print_poses(rows: Sequence[PoseRow]) -> None:
    """A line for every held step of pressure."""
    print("\nfinger            pressure [kPa]   bend [degrees]   pose error [mm]   fingertip error [mm]")
    for row in rows:
        print(
            f"{row.finger:<17} {row.pressure_kpa:>14.1f} {row.bend_angle_deg:>16.2f}"
            f" {row.pose_error_mm:>17.3f} {row.tip_error_mm:>22.3f}"
        )


def print_steps(rows: Sequence[StepRow]) -> None:
    """A line for every step of the opening."""
    print("\nstep  from [mm]    to [mm]  overshoot [%]  settling [s]  steady error [mm]: estimated     true")
    for row in rows:
        print(
            f"{row.step:>4} {row.from_mm:>10.1f} {row.to_mm:>10.1f} {row.overshoot_percent:>14.2f}"
            f" {row.settling_s:>13.2f} {row.steady_error_estimated_mm:>29.4f} {row.steady_error_true_mm:>8.3f}"
        )


def print_truth(row: Judged) -> None:
    """What truly became of the object of a task."""
    print(
        f"In truth: {row.placed_error_mm:.1f} mm and {row.placed_angle_deg:.1f} degrees from the goal,"
        f" slip in the fingers {row.slip_mm:.1f} mm, normal force of a finger up to {row.peak_force_n:.2f} N"
    )


def print_phases(rows: Sequence[PhaseRow], outcome: Outcome, task: TaskConfig) -> None:
    """A line for every phase of a task, and how it ended."""
    print("\nphase           began [s]  lasted [s]  at its end:  opening [mm]  torque [mN m]  pressure [kPa]")
    for row in rows:
        print(
            f"{row.phase:<15} {row.began_s:>9.2f} {row.lasted_s:>11.2f} {row.opening_mm:>26.1f}"
            f" {row.torque_mnm:>14.1f} {row.pressure_kpa:>15.1f}"
        )
    late = f", not over after {task.time_limit:g} s (task.time_limit)" if outcome == Outcome.RUNNING else ""
    print(f"\nOutcome, as estimated: {outcome.words}{late}")


def print_claims(claims: Sequence[Claim]) -> None:
    """A line for each, with our number, and how many fail."""
    width = max(len(claim.text) for claim in claims)
    print(f"\n{'claim':<{width}}  by     here")
    for claim in claims:
        word = "holds" if claim.holds else _red("FAILS")
        print(f"{claim.text:<{width}}  {claim.source:<6} {word}: {claim.number}")
    summary = verdict(claims)
    print("\n" + (summary if all(claim.holds for claim in claims) else _red(summary)))


def _red(text: str) -> str:
    """Red where somebody looks; a file or a pipe gets plain text."""
    return f"\033[31m{text}\033[0m" if sys.stdout.isatty() else text


_CORRELATED = 0.9


def print_identified(found: Identified) -> None:
    """Parameters with their confidence, what cannot be told apart, and a line for every recording."""
    free, x = found.fit.free, found.fit.x
    print(f"\nmarkers off by {100 * found.fit.root_mean_square:.2f} % of the largest displacement (root mean square)\n")
    print(f"{'parameter':<20}{'began':>12}{'fitted':>12}  standard deviation")
    columns = zip(free.names, free.units, free.values(free.start), free.values(x), strict=True)
    for i, (name, unit, began, value) in enumerate(columns):
        std = found.confidence.std[i] * (abs(value) if free.is_positive[i] else 1)
        print(f"{name:<20}{began:>12.5g}{value:>12.5g}  {std:.2g} {unit}")
    finger = found.model.finger
    remains = 1 - sum(branch.share for branch in finger.creep)
    if finger.creep:
        print(f"Young's modulus once all creep is over: {finger.base.youngs_modulus * remains:.5g} Pa")
    _print_correlations(found)
    print(f"\n{'':<20}{'':>6}{'error of markers [mm]':>24}{'tip':>8}{'settled turn':>18}{'creep':>16}{'rise':>14}")
    print(
        f"{'recording':<20}{'':>6}{'settled':>12}{'motion':>12}{'[%]':>8}{'[degrees]':>18}{'[degrees]':>16}{'[ms]':>14}"
    )
    for row in found.scores:
        _print_fit_row(row)
    for row in found.scores:
        if not np.isnan(row.frequency_hz + row.simulated_frequency_hz):
            swing = f"{row.frequency_hz:.2f} Hz ({row.simulated_frequency_hz:.2f})"
            print(f"{row.recording}: swings at {swing}, decrement {row.decrement:.2f} ({row.simulated_decrement:.2f})")
    print("In brackets: simulated. The times of events are fitted to each recording, those of a test as well.")


def _print_correlations(found: Identified) -> None:
    names, correlation = found.fit.free.names, found.confidence.correlation
    for i in range(len(names)):
        for j in range(i):
            if abs(correlation[i, j]) > _CORRELATED:
                print(f"correlated: {names[j]} and {names[i]} ({correlation[i, j]:+.3f})")
    for together in found.confidence.unresolved:
        what = " and ".join(together)
        says = "cannot be told apart" if len(together) > 1 else "is hardly seen"
        print(f"{what} {says} in these recordings: fix one, or add others")


def _print_fit_row(row: MotionScore) -> None:
    turn = f"{row.settled_turn_deg:.2f} ({row.simulated_settled_turn_deg:.2f})"
    creep = f"{row.creep_deg:.2f} ({row.simulated_creep_deg:.2f})"
    rise = f"{row.rise_ms:.0f} ({row.simulated_rise_ms:.0f})"
    errors = f"{row.settled_error_mm:>12.2f}{row.motion_error_mm:>12.2f}{row.tip_error_percent:>8.1f}"
    print(f"{row.recording:<20}{row.role:>6}{errors}{turn:>18}{creep:>16}{rise:>14}")


def print_replay(replayed: Sequence[Replayed], table: Sequence[ReplayRow]) -> None:
    """What was fitted to what, and a line for every estimator."""
    print("\nEstimated with what others were fitted to; motion capture of a recording only scores it:")
    for one in replayed:
        creep = ", ".join(f"{branch.share:g} in {branch.time:g} s" for branch in one.fitted.arm.finger.creep)
        of_fit = f"creep {creep}; wires {1e3 * one.fitted.delay:.0f} ms late"
        print(f"  {one.name:<12} fitted to {', '.join(one.fitted_on)} ({of_fit})")
    bodies = list(dict.fromkeys(row.body for row in table))
    for body in reversed(bodies):
        names = list(dict.fromkeys(row.recording for row in table if row.recording != ALL))
        print(f"\nerror of '{body}' [mm]      mean  median     95 %     max    mean of: " + "  ".join(names))
        for row in table:
            if row.body == body and row.recording == ALL:
                _print_row(row, [other for other in table if _is_part(other, row)])


def _is_part(other: ReplayRow, row: ReplayRow) -> bool:
    same = (other.estimator, other.sections, other.body) == (row.estimator, row.sections, row.body)
    return same and other.recording != ALL


def _print_row(row: ReplayRow, parts: Sequence[ReplayRow]) -> None:
    name = f"{row.estimator}, {row.sections} per side"
    numbers = row.mean_mm, row.median_mm, row.percentile_95_mm, row.max_mm
    means = "  ".join(f"{part.mean_mm:>{len(part.recording)}.2f}" for part in parts)
    print(f"{name:<22}" + "".join(f"{number:>8.2f}" for number in numbers) + f"{'':>13}{means}")


_BEST = 5  # placements that are listed


def print_ranking(rows: Sequence[PlacementRow], equal: int) -> None:
    """The best few, equal sections and the worst."""
    shown = sorted({*range(min(_BEST, len(rows))), equal, len(rows) - 1})
    with_contacts = not math.isnan(rows[0].force_error_n)
    width = max(len(rows[i].borders) for i in shown)
    heading = "   force [N]   place [mm]   missed" if with_contacts else ""
    print(f"\n{'rank':>4}  {'borders':<{width}}   pose error [mm]{heading}")
    for i in shown:
        row = rows[i]
        contact = f"{row.force_error_n:>12.3f} {row.place_error_mm:>12.1f} {row.missed_percent:>6.1f} %"
        line = f"{row.rank:>4}  {row.borders:<{width}} {row.pose_error_mm:>17.3f}{contact if with_contacts else ''}"
        print(line + ("   equal sections" if i == equal else ""))


def print_left_out(rows: Sequence[LeftOutRow]) -> None:
    """What placed sensors gain where they were not placed."""
    if not rows:
        return
    width, name = max(len(row.borders) for row in rows), max(len(row.run) for row in rows)
    print("\nplaced without the run in which they are tried, mean pose error [mm]:")
    print(f"{'':<{name}}  {'borders':<{width}}   equal   placed   better by")
    for row in rows:
        errors = f"{row.equal_mm:>7.3f} {row.placed_mm:>8.3f} {row.gain_percent:>9.1f} %"
        print(f"{row.run:<{name}}  {row.borders:<{width}} {errors}")


def print_snippet(placed: PlacedSensors, assumptions: Assumptions) -> None:
    """The part of a scenario that has the best placement, and an estimator that believes what was assumed."""
    borders = ", ".join(map(str, as_borders(placed.placements[0], placed.finger.segments)))
    believed = assumptions.uncertainty
    print(f"\nsensor:\n  sections: {len(placed.placements[0]) + 1}")
    print(f"  borders: [{borders}]")
    print(f"estimator:\n  type: {assumptions.estimator}\n  uncertainty:")
    print(f"    reading: {believed.reading:.2g}\n    bend_per_pressure: {believed.bend_per_pressure:.2g}")
