"""Markers of a recording."""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.hardware.marker_checks import check_base_rests, check_exchanged, check_rigid, check_size
from soft_gripper.diagrams.hardware.recording_schema import RecordingConfig
from soft_gripper.diagrams.hardware.table import Table
from soft_gripper.diagrams.hardware.units import LENGTH
from soft_gripper.diagrams.schema.ranges import require


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
