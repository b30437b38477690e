"""Replays on the terminal."""

from collections.abc import Sequence

from soft_gripper.evaluation.replay.replay_recordings import Replayed
from soft_gripper.evaluation.replay.replay_table import ALL, ReplayRow


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
    name = f"{row.estimator}, {row.sections} a side"
    numbers = row.mean_mm, row.median_mm, row.percentile_95_mm, row.max_mm
    means = "  ".join(f"{part.mean_mm:>{len(part.recording)}.2f}" for part in parts)
    print(f"{name:<22}" + "".join(f"{number:>8.2f}" for number in numbers) + f"{'':>13}{means}")
