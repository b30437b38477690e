"""What was identified, on the terminal."""

import numpy as np

from soft_gripper.evaluation.identify.identify import Identified
from soft_gripper.evaluation.identify.motion_scores import MotionScore

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
        _print_row(row)
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


def _print_row(row: MotionScore) -> None:
    turn = f"{row.settled_turn_deg:.2f} ({row.simulated_settled_turn_deg:.2f})"
    creep = f"{row.creep_deg:.2f} ({row.simulated_creep_deg:.2f})"
    rise = f"{row.rise_ms:.0f} ({row.simulated_rise_ms:.0f})"
    errors = f"{row.settled_error_mm:>12.2f}{row.motion_error_mm:>12.2f}{row.tip_error_percent:>8.1f}"
    print(f"{row.recording:<20}{row.role:>6}{errors}{turn:>18}{creep:>16}{rise:>14}")
