"""What is missing in a recording: times, rows, samples."""

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.hardware.table import Table
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.errors import InputError

_FEWEST = 2  # samples, of which anything can be said
_LONGEST_GAP = 60.0  # s, between two rows of one recording


def without_repeats(table: Table, time: str, unit: float) -> tuple[Table, int]:
    """The samples that have a time of their own, and how many were left out; `unit` of the times, s.

    Raises:
        InputError: if time runs backwards, most of it stands still, or rows are so far apart that they are of several
            recordings.
    """
    t = table.columns("time", [time])[:, 0]
    timed = table.kept(np.isfinite(t))
    t = t[np.isfinite(t)]
    require(len(t) >= _FEWEST, table.path, time, len(t), f"needs at least {_FEWEST} samples that have a time")
    back = np.flatnonzero(np.diff(t) < 0)
    if len(back):
        row, value = int(timed.rows[back[0] + 1]), float(t[back[0] + 1])
        expected = f"time runs backwards in row {row}, after {t[back[0]]:g}: split the file there, or sort it"
        raise InputError(table.path, time, value, expected)
    far = np.flatnonzero(np.diff(t) * unit > _LONGEST_GAP)
    if len(far):
        row, value = int(timed.rows[far[0] + 1]), float(t[far[0] + 1])
        expected = f"a gap of more than {_LONGEST_GAP:g} s before row {row}, after {t[far[0]]:g}: split the file there"
        raise InputError(table.path, time, value, expected)
    own = np.concatenate(([True], np.diff(t) > 0))
    row = int(timed.rows[np.argmin(own)])
    expected = f"most rows repeat a time, the first of them row {row}: does the clock count seconds alone?"
    require(own.mean() > 0.5, table.path, time, float(t[np.argmin(own)]), expected)
    return timed.kept(own), len(table.values) - int(own.sum())


def gaps_of(
    table: Table, repeated: int, time: Array, markers: dict[str, Array], reference: NDArray[np.bool_]
) -> tuple[str, ...]:
    """What is missing, in words; `reference` is true in the reference span, (T,)."""
    found = []
    if table.dropped:
        found.append(f"{len(table.dropped)} rows do not parse, the first of them row {table.dropped[0]}")
    if repeated:
        found.append(f"{repeated} rows have no time of their own")
    for name, p in markers.items():
        lost = np.any(np.isnan(p), axis=1)
        if lost.any():
            first, longest = time[np.argmax(lost)], _longest(time, lost)
            text = f"{name}: {lost.sum()} of {len(lost)} samples are missing, the first at {first:.2f} s"
            found.append(f"{text}; the longest gap is {longest:.2f} s")
        if lost[reference].all():
            found.append(f"{name}: not seen in the reference span")
    return tuple(found)


def _longest(time: Array, lost: NDArray[np.bool_]) -> float:
    """The longest time between two samples that are seen, with lost ones between them, s."""
    seen = np.concatenate((time[:1], time[~lost], time[-1:]))
    return float(np.diff(seen).max())
