"""Prints tables of fits and replays, and the progress of a fit."""

import sys
import time
from collections.abc import Callable, Sequence

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.identification.confidence import Confidence
from soft_gripper.extras.hardware.identification.fit import MotionScore
from soft_gripper.extras.hardware.identification.free_parameters import FreeParameters, Model
from soft_gripper.extras.hardware.identification.identified_finger import (
    Identified,
    Tested,
    motion_doubts,
    repetitions,
)
from soft_gripper.extras.hardware.identification.model_band import BandRow, extrapolations
from soft_gripper.extras.hardware.identification.settled_states import IdentifiedStates, TestedStates, state_doubts
from soft_gripper.extras.hardware.least_squares import Progress
from soft_gripper.extras.hardware.measured import SI
from soft_gripper.extras.hardware.replay.held_out import ALL, ArmReplay, ReplayRow
from soft_gripper.extras.hardware.replay.measured_scores import MeasuredReplay
from soft_gripper.files.row_table import print_rows, print_table
from soft_gripper.sensors.strain_errors import MINUTE

_MIN_PRINTED_CORRELATION = 0.9


class FitProgress:
    """Prints a line for each step, and writes the finger that is the best so far.

    `write` is called with the model and a remark that says how far the search has come.
    """

    def __init__(self, title: str, write: Callable[[Model, str], None]):
        self._title, self._write = title, write
        self._best, self._begin = np.inf, time.monotonic()

    def __call__(self, progress: Progress[Model]) -> None:
        """Reports a step."""
        error = f"marker error {100 * progress.error:.2f} %"
        balance_text = f", {progress.missing // 3} markers in no balance" if progress.missing else ""
        elapsed = f"{time.monotonic() - self._begin:.0f} s"
        print(f"{self._title}: step {progress.step}, {error}{balance_text}, {elapsed}", file=sys.stderr, flush=True)
        if progress.error < self._best:
            self._best = progress.error
            self._write(progress.model, f"Not final: the search had come to step {progress.step}, {error}")


def print_identified(tested: Tested) -> None:
    """Prints a line for each recording; of a fit first the parameters, with their confidence and correlations."""
    if isinstance(tested, Identified):
        print(f"\nmarker error {100 * tested.fit.error:.2f} % of the largest displacement (root mean square)")
        _print_parameters(tested.fit.free, tested.fit.x, tested.confidence)
        finger = tested.model.finger
        if finger.creep:
            modulus = finger.base.youngs_modulus * (1 - sum(branch.share for branch in finger.creep))
            print(f"Young's modulus after all creep: {modulus:.5g} Pa")
        _print_correlations(tested.confidence)
    columns = {"recording": "", "role": "", "settled": ".2f", "motion": ".2f", "tip [%]": ".1f"}
    columns |= dict.fromkeys(("settled turn [degrees]", "creep [degrees]", "recovery [degrees]"), ">")
    columns |= dict.fromkeys(("50 % [ms]", "63 % [ms]"), ">")
    print_table(columns, map(_score_cells, tested.scores), "marker errors [mm], and measured motion")
    for row in tested.scores:
        if not np.isnan(row.frequency_hz + row.simulated_frequency_hz):
            swing = f"{row.frequency_hz:.2f} Hz ({row.simulated_frequency_hz:.2f})"
            print(f"{row.recording}: swings at {swing}, decrement {row.decrement:.2f} ({row.simulated_decrement:.2f})")
    for text in repetitions(tested):
        print(text)
    for motion in tested.motions:
        if motion.hold is not None:
            hold_text = f"{1e3 * motion.hold.sag:.1f} mm low, turned by {np.degrees(motion.hold.turn):.1f} degrees"
            print(f"{motion.name}: held {hold_text}")
    print("In brackets: simulated. Event times, and a held pose if it is free, are fitted to each recording, including")
    print("held-out ones; where the hold is unknown, the hand is taken to have held the finger straight. 50 and 63 %:")
    print("times that the turn is below these shares of the settled one, all swings together.")
    for doubt in motion_doubts(tested):
        print(f"WARNING: {doubt}")


def print_identified_states(tested: TestedStates) -> None:
    """Prints fitted parameters, and the errors of every recording and family."""
    print()
    if isinstance(tested, IdentifiedStates):
        _print_parameters(tested.fit.free, tested.fit.x, tested.confidence)
        _print_correlations(tested.confidence)
    print_rows(tested.scores, "marker errors, the mean offset removed, by the family of the rows")
    if isinstance(tested, IdentifiedStates):
        print("Left out: predicted by a fit to the other families; each family has a mean offset of its own.")
        for doubt in state_doubts(tested):
            print(f"WARNING: {doubt}")


def print_bands(rows: Sequence[BandRow]) -> None:
    """Prints the shares of markers in their bands, and recordings far from the fitted states."""
    print_rows(rows, "markers and their 95 % bands, which widen away from the fitted states")
    for warning in extrapolations(rows):
        print(f"WARNING: {warning}")


def _print_parameters(free: FreeParameters, x: Array, confidence: Confidence) -> None:
    stds = [confidence.std_of(name) for name in free.names] * np.where(free.is_positive, np.abs(free.values(x)), 1)
    key_rows = zip(free.names, free.values(free.start), free.values(x), stds, free.units, strict=True)
    columns = {"parameter": "", "initial": ".5g", "fitted": ".5g", "standard deviation": ".2g", "": ""}
    print_table(columns, key_rows)
    for dropped in confidence.undetermined:
        print(dropped)


def _print_correlations(confidence: Confidence) -> None:
    names, correlation = confidence.names, confidence.correlation
    for i, j in np.argwhere(np.abs(np.tril(correlation, -1)) > _MIN_PRINTED_CORRELATION):
        print(f"correlated: {names[j]} and {names[i]} ({correlation[i, j]:+.3f})")


def _score_cells(row: MotionScore) -> list[str | float]:
    def both(column: str, form: str) -> str:
        measured, simulated = getattr(row, column), getattr(row, f"simulated_{column}")
        return "not known" if np.isnan(measured) else f"{measured:{form}} ({simulated:{form}})"

    turn_texts = (both(column, ".2f") for column in ("settled_turn_deg", "creep_deg", "recovery_deg"))
    errors = row.settled_error_mm, row.motion_error_mm, row.tip_error_percent
    return [row.recording, row.role, *errors, *turn_texts, both("t50_ms", ".0f"), both("t63_ms", ".0f")]


def print_measured(replay: MeasuredReplay) -> None:
    """Prints the corrections of the instruments, and the scores of estimates in each press and over all."""
    print()
    for kind, instrument in replay.instruments.items():
        if kind == "angle":
            continue
        zeros = ", ".join("not found" if np.isnan(zero) else f"{zero:.3g}" for zero in instrument.zeros)
        drift = "not found" if np.isnan(instrument.drift) else f"{MINUTE * instrument.drift:.3g} {SI[kind]} a minute"
        print(f"{kind}: reads {instrument.delay:.2f} s late, drifts by {drift}; zero of each run {zeros} {SI[kind]}")
        if np.isnan(instrument.drift) or np.isnan(instrument.zeros).any():
            print(f"WARNING: what is not found of the {kind} is taken for 0: let the finger rest free between presses")
    for run in replay.runs:
        for warning in run.warnings:
            print(f"WARNING: {run.log.name}: {warning}")
    print_rows(replay.presses, "presses: medians of what is measured and estimated, and 95 % bands")
    print()
    print_rows(replay.scores, "all presses; ratio: of what is measured to what is estimated")


def print_replay(replay: ArmReplay) -> None:
    """Prints which recordings each fit used, and a line for each estimator."""
    print("\nEach recording is estimated with a model fitted to others; its motion capture is used only for scoring:")
    for replayed in replay.replayed:
        creep = ", ".join(f"{branch.share:g} in {branch.time:g} s" for branch in replayed.fitted.arm.finger.creep)
        fit = f"creep {creep}; wires delayed by {1e3 * replayed.fitted.geometry.delay:.0f} ms"
        print(f"  {replayed.name:<12} fitted to {', '.join(replayed.fitted_on)} ({fit})")
        for warning in replayed.warnings:
            print(f"WARNING: {replayed.name}: {warning}")
    names = [name for name in dict.fromkeys(row.recording for row in replay.table) if name != ALL]
    for body in reversed(dict.fromkeys(row.body for row in replay.table)):
        rows = [row for row in replay.table if row.body == body]
        columns = {"": "", "mean": ".2f", "median": ".2f", "95 %": ".2f", "max": ".2f"}
        columns |= {"in band [%]": ".1f", "rms z": ".2f", "band": ".2f", "far [%]": ".1f"} | {
            f"mean of {name}": ".2f" for name in names
        }
        cells = [_replay_cells(row, rows) for row in rows if row.recording == ALL]
        print_table(columns, cells, f"error of '{body}' [mm]")


def _replay_cells(row: ReplayRow, rows: Sequence[ReplayRow]) -> list[str | float]:
    errors = row.mean_mm, row.median_mm, row.percentile_95_mm, row.max_mm
    band = row.within_band_percent, row.rms_z, row.band_mm, row.far_percent
    key = row.estimator, row.sections
    mean_errors = [one.mean_mm for one in rows if (one.estimator, one.sections) == key and one.recording != ALL]
    return [f"{row.estimator}, {row.sections} per side", *errors, *band, *mean_errors]
