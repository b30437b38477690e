"""The tables of the live page: what is estimated of every finger, and what has happened to the readings."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict

import numpy as np
from pydrake.systems.framework import OutputPort

from soft_gripper.arrays import Array
from soft_gripper.estimators.calibration_range import DISTANCE, FAR
from soft_gripper.extras.bench.watch import Counts
from soft_gripper.signals import signal_of

Cell = str | tuple[str, str]  # its text, or its text and how it is marked: "bad", "name"
Table = list[str | list[Cell]]  # a caption, the head, and rows
_UNKNOWN = "-"
_COUNTERS_PER_ROW = 2  # the panel is narrow


def _millimetres(*values: float) -> str:
    return ", ".join(f"{1e3 * value:.1f}" for value in values)


def _with_std(value: float, std: float) -> str:
    return f"{value:.2f} ± {std:.2f}" if math.isfinite(std) else f"{value:.2f}"


def _bounded(force: float) -> str:
    return f"{force:.2f}" if math.isfinite(force) else "not known"


# Rows, the signals that each is made of, and how these are written; None: by their meanings.
_ROWS: dict[str, tuple[tuple[str, ...], Callable[..., str] | None]] = {
    "tip x, z [mm]": (("tip_pose",), lambda tip: _millimetres(*tip[:2])),
    "tip ± [mm]": (("position_std",), lambda std: f"{1e3 * std[-1]:.2f}"),
    "contact": (("contact_answer",), None),
    "transverse force [N]": (
        ("transverse_force", "transverse_force_std"),
        lambda force, std: _with_std(force[0], std[0]),
    ),
    "at most [N]": (("contact_probability", "contact_force_bounds"), lambda _, bounds: _bounded(bounds[2])),
    "contact at [mm]": (("contact_arc_length",), lambda place: _millimetres(place[0])),
    "health": (("fault",), None),
    "calibration": (
        (FAR, DISTANCE),
        lambda far, away: f"{'far' if far[0] else 'within'}, {away.max():.1f} spreads away",
    ),
}
_BAD = "fault", FAR  # signals of which anything but 0 is marked


def needed_signals(fingers: Iterable[str], known: Collection[str]) -> list[str]:
    """The names of the known signals that `finger_table` shows."""
    names = (f"{finger}.{own}" for finger in fingers for signals, _ in _ROWS.values() for own in signals)
    return [name for name in names if name in known]


def finger_table(
    fingers: Sequence[str],
    known: Mapping[str, OutputPort],
    values: Mapping[str, Array],
    disagreeing: Collection[str] = (),
) -> Table:
    """A column for every finger, with a row for whatever is estimated of any.

    Args:
        fingers: their names.
        known: the ports of the signals, by name, for their meanings.
        values: of `needed_signals`, (size,) each; a missing one is unknown.
        disagreeing: those whose readings and drive disagree.
    """
    rows: list[list[Cell]] = []
    for title, (signals, text) in _ROWS.items():
        own = [[f"{finger}.{name}" for name in signals] for finger in fingers]
        if any(names[0] in known for names in own):
            rows.append([title, *(_cell(names, known, values, text) for names in own)])
    if disagreeing:
        marked: list[Cell] = [("disagree", "bad") if finger in disagreeing else "agree" for finger in fingers]
        rows.append(["readings and drive", *marked])
    return ["estimates", ["", *fingers], *rows]


def _cell(
    names: Sequence[str], known: Mapping[str, OutputPort], values: Mapping[str, Array], text: Callable[..., str] | None
) -> Cell:
    found = [values.get(name, _NOTHING) for name in names]
    if not math.isfinite(found[0][0]):
        return _UNKNOWN
    said = text(*found) if text is not None else signal_of(known[names[0]]).meanings[int(found[0][0])]
    return (said, "bad") if names[0].rpartition(".")[2] in _BAD and found[0][0] else said


_NOTHING = np.array([np.nan])


def readings_table(counts: Counts) -> Table:
    """The counters of the watch-dog; those of what went wrong are marked."""
    cells: list[Cell] = []
    for name, number in asdict(counts).items():
        cells += [(name, "name"), (str(number), "bad") if number and name != "used" else str(number)]
    width = 2 * _COUNTERS_PER_ROW
    return ["readings", [], *(cells[i : i + width] for i in range(0, len(cells), width))]
