"""The tables of the live page: what is estimated of every finger, and what has happened to the readings."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict

import numpy as np
from pydrake.systems.framework import OutputPort

from soft_gripper.arrays import Array
from soft_gripper.extras.bench.watch import Counts
from soft_gripper.signals import signal_of

Cell = str | tuple[str, str]  # its text, or its text and how it is marked: "bad", "name"
Table = list[str | list[Cell]]  # a caption, the head, and rows
_UNKNOWN = "-"
_COUNTERS_PER_ROW = 4


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
    "force [N]": (("contact_force", "contact_force_std"), lambda force, std: _with_std(force[0], std[0])),
    "at most [N]": (("contact_probability", "contact_force_bounds"), lambda _, bounds: _bounded(bounds[2])),
    "contact at [mm]": (("contact_arc_length",), lambda place: _millimetres(place[0])),
    "health": (("fault",), None),
}


def needed_signals(fingers: Iterable[str], known: Collection[str]) -> list[str]:
    """The names of the known signals that `finger_table` shows."""
    names = (f"{finger}.{own}" for finger in fingers for signals, _ in _ROWS.values() for own in signals)
    return [name for name in names if name in known]


def finger_table(fingers: Sequence[str], known: Mapping[str, OutputPort], values: Mapping[str, Array]) -> Table:
    """A column for every finger, with a row for whatever is estimated of any.

    Args:
        fingers: their names.
        known: the ports of the signals, by name, for their meanings.
        values: of `needed_signals`, (size,) each; a missing one is unknown.
    """
    rows: list[list[Cell]] = []
    for title, (signals, text) in _ROWS.items():
        own = [[f"{finger}.{name}" for name in signals] for finger in fingers]
        if any(names[0] in known for names in own):
            rows.append([title, *(_cell(names, known, values, text) for names in own)])
    return ["estimates", ["", *fingers], *rows]


def _cell(
    names: Sequence[str],
    known: Mapping[str, OutputPort],
    values: Mapping[str, Array],
    text: Callable[..., str] | None,
) -> Cell:
    found = [values.get(name, _NOTHING) for name in names]
    if not math.isfinite(found[0][0]):
        return _UNKNOWN
    if text is not None:
        return text(*found)
    meaning, is_fault = signal_of(known[names[0]]).meanings[int(found[0][0])], names[0].endswith(".fault")
    return (meaning, "bad") if is_fault and found[0][0] else meaning


_NOTHING = np.array([np.nan])


def readings_table(counts: Counts) -> Table:
    """The counters of the watch-dog; those of what went wrong are marked."""
    cells: list[Cell] = []
    for name, number in asdict(counts).items():
        cells += [(name, "name"), (str(number), "bad") if number and name != "used" else str(number)]
    width = 2 * _COUNTERS_PER_ROW
    return ["readings", [], *(cells[i : i + width] for i in range(0, len(cells), width))]
