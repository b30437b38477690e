"""Descriptions of hardware recordings: finding, reading and checking them."""

import math
import os
import re
from pathlib import Path

from pydrake.common.yaml import yaml_dump, yaml_load_typed

from soft_gripper.errors import InputError
from soft_gripper.files.document import check_document, positive, require
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.hardware.recordings.schema import PressuresConfig, RecordingConfig
from soft_gripper.hardware.recordings.units import LENGTH, PRESSURE, TIME, factor
from soft_gripper.models import DIRECTORY

SHIPPED = DIRECTORY / "recordings"


def description_names() -> list[str]:
    """Names of the shipped descriptions."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_description(name_or_path: str | Path) -> RecordingConfig:
    """Reads a shipped description by its name, such as "clamped_beam", or any by its path.

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        path = SHIPPED / f"{name_or_path}.yaml"
        known = ", ".join(description_names())
        shipped = str(name_or_path) in description_names()
        require(shipped, "recording", "--as", str(name_or_path), f"not shipped; known: {known}; or give a path")
    document = read_yaml(path)
    check_document(path, document, RecordingConfig)
    config: RecordingConfig = yaml_load_typed(schema=RecordingConfig, data=yaml_dump(document))
    _check_units(path, config)
    _check_vectors(path, config)
    _check_names(path, config)
    if config.finger is not None and not config.finger.startswith("package://"):
        config.finger = os.path.realpath(path.parent / config.finger)
    return config


def _check_units(path: Path, config: RecordingConfig) -> None:
    require(config.time_unit in TIME, path, "time_unit", config.time_unit, f"one of {', '.join(TIME)}")
    if config.markers:
        factor(path, "markers", config.markers.unit, LENGTH)
    for name, pose in config.poses.items():
        factor(path, f"poses.{name}", pose.unit, LENGTH)
    if config.pressures:
        factor(path, "pressures", config.pressures.unit, PRESSURE, config.pressures.scale)
        _check_chambers(path, config.pressures)
    if config.lengths:
        factor(path, "lengths", config.lengths.unit, LENGTH, config.lengths.scale)
    for i, way in enumerate(config.commanded_pressure):
        factor(path, f"commanded_pressure[{i}]", way.unit, PRESSURE)


def _check_chambers(path: Path, pressures: PressuresConfig) -> None:
    sections, count = pressures.sections, len(pressures.columns)
    fine = sections is None or (len(sections) == count and min(sections, default=1) >= 1)
    require(fine, path, "pressures.sections", sections, f"give one for each of the {count} columns, counted from 1")


def _check_vectors(path: Path, config: RecordingConfig) -> None:
    frame = config.frame
    for field, vector in (("frame.origin", frame.origin), ("frame.z", frame.z), ("frame.x", frame.x)):
        require(vector is None or _finite(vector, 3), path, field, vector, "give three finite numbers")
    require(_finite(config.gravity or [0] * 3, 3), path, "gravity", config.gravity, "give three finite numbers, m/s^2")
    require(_finite(config.load_place or [0] * 2, 2), path, "load_place", config.load_place, "give x and z, m")
    zx, zz, xx = (sum(a * b for a, b in zip(u, v, strict=True)) for u, v in _pairs(frame.z, frame.x))
    require(zx**2 < 0.99 * zz * xx, path, "frame.x", frame.x, "give a direction across frame.z; neither may be zero")
    require(positive(config.length), path, "length", config.length, "give a finite length above 0, m")
    require(positive(config.reference), path, "reference", config.reference, "give a finite time above 0, s")


def _pairs(z: list[float], x: list[float]) -> tuple[tuple[list[float], list[float]], ...]:
    return (z, x), (z, z), (x, x)


def _check_names(path: Path, config: RecordingConfig) -> None:
    require(config.event in (None, "release", "step"), path, "event", config.event, 'give "release" or "step"')
    header = config.header or []
    twice = sorted({name for name in header if header.count(name) > 1})
    require(not twice, path, "header", twice, "every column needs a name of its own")
    for i, way in enumerate(config.commanded_pressure):
        _check_pattern(path, f"commanded_pressure[{i}]", way.pattern)
    if config.load:
        _check_pattern(path, "load", config.load.pattern)
        for number, mass in config.load.masses.items():
            require(positive(mass), path, f"load.masses.{number}", mass, "give a mass above 0, kg")
    for name, pose in config.poses.items():
        require(len(pose.position) == 3, path, f"poses.{name}.position", pose.position, "name the columns of x, y, z")
        expected = "name the columns of w, x, y, z"
        require(len(pose.quaternion) == 4, path, f"poses.{name}.quaternion", pose.quaternion, expected)
    if config.markers:
        fine = "{marker}" in config.markers.columns and "{axis}" in config.markers.columns
        require(fine, path, "markers.columns", config.markers.columns, "must have {marker} and {axis}")
    for name, wire in config.lengths.wires.items() if config.lengths else ():
        where = f"lengths.wires.{name}"
        require(wire.side in ("inner", "outer"), path, f"{where}.side", wire.side, 'give "inner" or "outer"')
        require(wire.section >= 1, path, f"{where}.section", wire.section, "sections count from 1 at the base")
    if config.lengths:
        expected = "give the distance of the two sides, m"
        require(positive(config.lengths.spacing), path, "lengths.spacing", config.lengths.spacing, expected)


def _check_pattern(path: Path, field: str, pattern: str) -> None:
    try:
        groups = re.compile(pattern).groups
    except re.error as error:
        raise InputError(path, f"{field}.pattern", pattern, f"is no regular expression: {error}") from None
    require(groups == 1, path, f"{field}.pattern", pattern, "needs one group, the number: such as (\\d+)")


def _finite(vector: list[float], size: int) -> bool:
    return len(vector) == size and all(map(math.isfinite, vector))
