"""Whether markers can be where a recording says: units, exchanged names, rigid bodies."""

from itertools import combinations
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import require
from soft_gripper.hardware.recordings.schema import LENGTH, RecordingConfig
from soft_gripper.hardware.recordings.table import Table

_FURTHEST = 5.0  # lengths of the finger between its bodies, at most
_NEAREST = 0.1  # and at least, or its markers are together
_RIGID = 0.05  # lengths of the finger by which the distance of two markers on one body may change
_RESTS = 0.02  # lengths of the finger that a base may move more than the tip
_LOST = 0.1  # s, after which a marker that is seen again is not compared with where it was


def check_size(path: Path, field: str, points: dict[str, Array], length: float) -> None:
    """Whether the largest distance of points, each (T, 3) m, fits a finger of `length`.

    Raises:
        InputError: if it is so large or small that the unit must be wrong.
    """
    seen = [point[~np.isnan(point).any(axis=1)] for point in points.values()]
    places = np.array([np.median(point, axis=0) for point in seen if len(point)])
    if len(places) < 2:
        return
    size = float(np.linalg.norm(np.ptp(places, axis=0)))
    if not _NEAREST * length < size < _FURTHEST * length:
        expected = f"they spread over {size:.3g} m, and the finger is {length:g} m long: is the unit right?"
        raise InputError(path, f"{field}.unit", f"{len(places)} bodies or markers", expected)


def check_exchanged(path: Path, time: Array, markers: dict[str, Array]) -> None:
    """Whether two markers, each (T, 3) m, change names: both then jump, each to where the other was.

    Raises:
        InputError: naming both markers, and when they do so.
    """
    for a, b in combinations(markers, 2):
        seen = np.flatnonzero(~np.isnan(markers[a] + markers[b]).any(axis=1))
        p, q, t = markers[a][seen], markers[b][seen], time[seen]
        kept = _distance(p[1:], p[:-1]) + _distance(q[1:], q[:-1])
        exchanged = _distance(p[1:], q[:-1]) + _distance(q[1:], p[:-1])
        jumps = np.flatnonzero((2 * exchanged < kept) & (np.diff(t) < _LOST))
        if len(jumps):
            times = ", ".join(f"{t[i + 1]:.2f}" for i in jumps[:6]) + (" ..." if len(jumps) > 6 else "")
            raise InputError(path, "markers", f"{a}, {b}", f"change names at {times} s: exchange their columns there")


def check_rigid(
    path: Path, time: Array, markers: dict[str, Array], bodies: dict[str, list[str]], length: float
) -> None:
    """Whether markers on one body, each (T, 3) m, keep their distances.

    Raises:
        InputError: naming the body, the markers, and when they do not.
    """
    for body, names in bodies.items():
        for a, b in combinations(names, 2):
            distance = _distance(markers[a], markers[b])
            change = np.abs(distance - np.nanmedian(distance)) if np.isfinite(distance).any() else np.zeros(1)
            if np.nanmax(change) > _RIGID * length:
                worst = int(np.nanargmax(change))
                found = f"their distance changes by {change[worst] * 1e3:.1f} mm at {time[worst]:.2f} s"
                raise InputError(path, f"markers.bodies.{body}", f"{a}, {b}", f"{found}: are they on one rigid body?")


def check_base_rests(path: Path, markers: dict[str, Array], bodies: dict[str, list[str]], length: float) -> None:
    """Whether the markers on the body "base" move less than those on "tip", or hardly.

    Raises:
        InputError: if they do not: the bodies' names are exchanged.
    """
    if "tip" not in bodies or "base" not in bodies:
        return
    moved = {body: max(_motion(markers[name]) for name in bodies[body]) for body in ("tip", "base")}
    if moved["base"] > moved["tip"] + _RESTS * length:
        expected = f"the base moves by {moved['base'] * 1e3:.1f} mm and the tip by {moved['tip'] * 1e3:.1f} mm"
        raise InputError(path, "markers.bodies", "base, tip", f"{expected}: are their markers exchanged?")


def _distance(p: Array, q: Array) -> Array:
    distance: Array = np.linalg.norm(p - q, axis=-1)
    return distance


def _motion(p: Array) -> float:
    """How far a marker gets from where it is in the median, 90th percentile: single outliers do not count."""
    seen = p[~np.isnan(p).any(axis=1)]
    return float(np.percentile(_distance(seen, np.median(seen, axis=0)), 90)) if len(seen) else 0.0


def markers_of(table: Table, config: RecordingConfig, time: Array) -> dict[str, Array]:
    """Markers (T, 3) m by name, in the axes of the recording; NaN where one is not seen.

    Raises:
        InputError: if one is missing, or they cannot be where the recording says (marker_checks).
    """
    if config.markers is None:
        return {}
    described, unit = config.markers, LENGTH[config.markers.unit]
    markers: dict[str, Array] = {}
    for name in (name for body in described.bodies.values() for name in body):
        columns = [described.columns.format(marker=name, axis=axis) for axis in "xyz"]
        p = table.columns("markers", columns) * unit
        p[np.isnan(p).any(axis=1) | (p == 0).all(axis=1)] = np.nan  # some systems write zeros for what is not seen
        markers[name] = p
    for body, names in described.bodies.items():
        seen = any(np.isfinite(markers[name]).any() for name in names)
        require(seen, table.path, f"markers.bodies.{body}", names, "none of them is ever seen")
    check_size(table.path, "markers", markers, config.length)
    check_exchanged(table.path, time, markers)
    check_rigid(table.path, time, markers, described.bodies, config.length)
    check_base_rests(table.path, markers, described.bodies, config.length)
    return markers
