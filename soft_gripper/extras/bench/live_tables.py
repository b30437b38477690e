"""The tables of the live page: estimates of every finger, and counts of readings."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import asdict

import numpy as np
from pydrake.systems.framework import OutputPort

from soft_gripper.arrays import Array
from soft_gripper.estimators.calibration_range import DISTANCE, FAR
from soft_gripper.extras.bench.watch import Counts
from soft_gripper.signals import signal_of

Cell = str | tuple[str, str]  # text, or text and mark: "bad", "name"
Table = list[str | list[Cell]]  # a caption, the head, and rows
_UNKNOWN_TEXT = "-"
_COUNTERS_PER_ROW = 2  # the panel is narrow


def _millimetres(*values: float) -> str:
    return ", ".join(f"{1e3 * value:.1f}" for value in values)


def _with_std(value: float, std: float) -> str:
    return f"{value:.2f} ± {std:.2f}" if math.isfinite(std) else f"{value:.2f}"


def _bound_text(force: float) -> str:
    return f"{force:.2f}" if math.isfinite(force) else "not known"


# Rows, their signals, and how these are written; None: by their meanings.
_TABLE_ROWS: dict[str, tuple[tuple[str, ...], Callable[..., str] | None]] = {
    "tip x, z [mm]": (("tip_pose",), lambda tip: _millimetres(*tip[:2])),
    "tip ± [mm]": (("position_std",), lambda std: f"{1e3 * std[-1]:.2f}"),
    "contact": (("contact_answer",), None),
    "transverse force [N]": (
        ("transverse_force", "transverse_force_std"),
        lambda force, std: _with_std(force[0], std[0]),
    ),
    "at most [N]": (("contact_probability", "contact_force_bounds"), lambda _, bounds: _bound_text(bounds[2])),
    "contact at [mm]": (("contact_arc_length",), lambda place: _millimetres(place[0])),
    "health": (("fault",), None),
    "calibration": (
        (FAR, DISTANCE),
        lambda far, away: f"{'far' if far[0] else 'within'}, {away.max():.1f} spreads away",
    ),
}
_ALARM_SIGNALS = "fault", FAR  # marked unless 0


def needed_signals(fingers: Iterable[str], available: Collection[str]) -> list[str]:
    """Names of the available signals that `finger_table` shows."""
    names = (f"{finger}.{signal}" for finger in fingers for signals, _ in _TABLE_ROWS.values() for signal in signals)
    return [name for name in names if name in available]


def finger_table(
    fingers: Sequence[str],
    ports: Mapping[str, OutputPort],
    values: Mapping[str, Array],
    disagreeing: Collection[str] = (),
) -> Table:
    """Makes a table with a column for every finger, and a row for every estimate.

    Args:
        fingers: their names.
        ports: of the signals, by name, for their meanings.
        values: of `needed_signals`, (size,) each; a missing one is unknown.
        disagreeing: those whose readings and drive disagree.
    """
    rows: list[list[Cell]] = []
    for title, (signals, text) in _TABLE_ROWS.items():
        finger_signals = [[f"{finger}.{name}" for name in signals] for finger in fingers]
        if any(names[0] in ports for names in finger_signals):
            rows.append([title, *(_cell(names, ports, values, text) for names in finger_signals)])
    if disagreeing:
        agreement_cells: list[Cell] = [("disagree", "bad") if finger in disagreeing else "agree" for finger in fingers]
        rows.append(["readings and drive", *agreement_cells])
    return ["estimates", ["", *fingers], *rows]


def _cell(
    names: Sequence[str], ports: Mapping[str, OutputPort], values: Mapping[str, Array], text: Callable[..., str] | None
) -> Cell:
    cell_values = [values.get(name, _UNKNOWN_VALUE) for name in names]
    if not math.isfinite(cell_values[0][0]):
        return _UNKNOWN_TEXT
    words = text(*cell_values) if text is not None else signal_of(ports[names[0]]).meanings[int(cell_values[0][0])]
    return (words, "bad") if names[0].rpartition(".")[2] in _ALARM_SIGNALS and cell_values[0][0] else words


_UNKNOWN_VALUE = np.array([np.nan])


def readings_table(counts: Counts) -> Table:
    """Makes a table of the watch's counters, with counters of faults marked."""
    cells: list[Cell] = []
    for name, count in asdict(counts).items():
        cells += [(name, "name"), (str(count), "bad") if count and name != "used" else str(count)]
    width = 2 * _COUNTERS_PER_ROW
    return ["readings", [], *(cells[i : i + width] for i in range(0, len(cells), width))]
