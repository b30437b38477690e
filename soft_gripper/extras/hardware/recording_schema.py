"""Schema of the description of a hardware recording, in YAML: columns by their names, units, frames and instruments.

An optional field that is omitted is None: there is no such item. A new kind of signal is a field of `RecordingConfig`
and part of its `columns`.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from math import radians
from operator import mul
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.text_pattern import (
    MAX_LENGTH,
    fill_pattern,
    has_syntax,
    pattern_problem,
    plain_number_pattern,
)
from soft_gripper.files.document import load_config
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.models import DIRECTORY
from soft_gripper.quantity import Violation, quantity

LENGTH = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}  # m
PRESSURE = {"Pa": 1.0, "hPa": 1e2, "mbar": 1e2, "kPa": 1e3, "bar": 1e5, "psi": 6894.757293168}  # Pa, NIST SP 811
ANGLE = {"rad": 1.0, "deg": radians(1.0)}  # rad
FORCE = {"N": 1.0, "mN": 1e-3, "gf": 9.80665e-3, "kgf": 9.80665, "lbf": 4.4482216}  # N, NIST SP 811
TORQUE = {"N m": 1.0, "N mm": 1e-3, "mN m": 1e-3, "gf cm": 9.80665e-5}  # N m
TIME = {"s": 1.0, "cs": 1e-2, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0, "d": 86400.0}  # s


@dataclass
class SourceConfig:
    """The source of the recording."""

    repository: str = ""
    path: str = ""
    license: str = ""


@dataclass
class TextConfig:
    """Format of a text file, as far as the file does not show it."""

    separator: str | None = quantity(None, filled=True)  # of the cells; " " stands for any number of spaces and tabs
    decimal: str | None = quantity(None, known=(".", ","))  # sign
    encoding: str | None = quantity(None, filled=True)  # such as latin-1


@dataclass
class FrameConfig:
    """The finger's frame B in the axes of the recording."""

    # Of the base of the finger; None: where the body "base" is in the mean over the reference
    origin: list[float] | None = quantity(None, "m", length=3)
    z: list[float] = quantity([0.0, 0.0, 1.0], length=3)  # along the straight finger; any length
    x: list[float] = quantity([1.0, 0.0, 0.0], length=3)  # toward the inner side; made normal to z

    def violations(self) -> Iterator[Violation]:
        zx, zz, xx = (sum(map(mul, u, v)) for u, v in ((self.z, self.x), (self.z, self.z), (self.x, self.x)))
        if not zx**2 < 0.99 * zz * xx:
            yield "x", self.x, "must be a direction across z; neither may be zero"


@dataclass
class MarkersConfig:
    """Markers and the bodies they are glued to. A C3D file names its points after the markers, and gives their unit."""

    columns: str = "{marker}_{axis}"  # of a table, with x, y and z for the axis
    unit: str = quantity("m", known=tuple(LENGTH))  # of those columns
    bodies: dict[str, list[str]] = field(default_factory=dict)  # markers by rigid body: "base", "tip"; empty: none
    # Markers on the finger whose places are known, x, y and z in the frame of the tip, or of `at`; of settled states
    places: dict[str, list[float]] = quantity({}, "m")
    # Arc lengths of the markers that are not at the tip, as fractions of the length
    at: dict[str, float] = quantity({}, least=0, most=1)

    def column_names(self, marker: str) -> list[str]:
        """The three columns of a marker."""
        return [fill_pattern(self.columns, {"marker": marker, "axis": axis}) for axis in "xyz"]

    def violations(self) -> Iterator[Violation]:
        if expected := pattern_problem(self.columns, ("marker", "axis")):
            yield "columns", self.columns, expected
        for body, names in self.bodies.items():
            if long_names := [name for name in names if len(name) > MAX_LENGTH]:
                yield f"bodies.{body}", long_names[0], f"must have at most {MAX_LENGTH} characters"
        for name, place in self.places.items():
            if name not in self.at and name not in self.bodies.get("tip", []):
                yield f"places.{name}", place, f"is not listed in bodies.tip: {', '.join(self.bodies.get('tip', []))}"
            if len(place) != 3:
                yield f"places.{name}", place, "must be 3 numbers"
        for name, fraction in self.at.items():
            if name not in self.places:
                yield f"at.{name}", fraction, f"has no place: {', '.join(self.places) or 'none is given'}"


@dataclass
class PoseConfig:
    """The pose of a rigid body, as motion capture reports it."""

    position: list[str] = quantity([], length=3)  # columns of x, y, z
    quaternion: list[str] = quantity([], length=4)  # columns of w, x, y, z, in this order
    unit: str = quantity("m", known=tuple(LENGTH))  # of the position


@dataclass
class PressuresConfig:
    """Measured pressures, one column per chamber.

    They are relative to the surroundings: sensors that measure against vacuum need either `ambient` or `zeroed`.
    """

    columns: list[str] = field(default_factory=list)
    sections: list[int] | None = quantity(None, least=1)  # section of each chamber, from the base; None: not given
    unit: str = quantity("Pa", known=(*PRESSURE, "V"))
    scale: float | None = quantity(None, "Pa/V", above=0)  # if the unit is V
    ambient: float | None = None  # what the columns have at the pressure of the surroundings, in their unit
    zeroed: bool = False  # whether the chambers are open in the reference span: its mean is subtracted

    def violations(self) -> Iterator[Violation]:
        yield from _scale_violations(self.unit, self.scale)
        if self.zeroed and self.ambient is not None:
            yield "ambient", self.ambient, "leave it out, or `zeroed`: either says what is subtracted"
        if self.sections is not None and len(self.sections) != len(self.columns):
            yield "sections", self.sections, f"must be one for each of the {len(self.columns)} columns"


@dataclass
class WireConfig:
    """A length sensor along one side of the finger, from its base to the end of a section."""

    column: str = ""
    side: str = quantity("inner", known=("inner", "outer"))
    section: int = quantity(1, least=1)  # section at whose end it is fixed, counted from the base


@dataclass
class LengthsConfig:
    """Length sensors, each with a constant offset that may be unknown."""

    wires: dict[str, WireConfig] = field(default_factory=dict)
    unit: str = quantity("m", known=(*LENGTH, "V"))
    scale: float | None = quantity(None, "m/V", above=0)  # if the unit is V
    spacing: float = quantity(0.0, "m", above=0)  # between the inner and the outer side

    def violations(self) -> Iterator[Violation]:
        yield from _scale_violations(self.unit, self.scale)


@dataclass
class TendonsConfig:
    """Lengths of tendons that are pulled in, from an unknown origin, see the finger's `slack`."""

    columns: dict[str, str] = field(default_factory=dict)  # by the tendon's name in the finger file
    # Tendons that a column lets out by as much as it pulls another in: their motor winds both
    antagonists: dict[str, str] = field(default_factory=dict)
    unit: str = quantity("m", known=(*LENGTH, *ANGLE))
    radius: float | None = quantity(None, "m", above=0)  # of the motors' pulleys, if the unit is an angle

    def violations(self) -> Iterator[Violation]:
        if (self.unit in ANGLE) != (self.radius is not None):
            yield "radius", self.radius, "must be given if and only if the unit is an angle"
        for name in self.columns.keys() & self.antagonists.keys():
            yield f"antagonists.{name}", self.antagonists[name], "is in columns too"

    @property
    def scale(self) -> float:
        """Lengths per unit of the columns, m."""
        return LENGTH[self.unit] if self.radius is None else self.radius * ANGLE[self.unit]


@dataclass
class LabelsConfig:
    """A column of text that names the motion of a row."""

    column: str = ""
    # Rows in which it matches the same text are a family, left out of a fit together. Text with {word} and {number},
    # and | between alternatives; empty: the whole label
    family: str = ""

    def violations(self) -> Iterator[Violation]:
        expected = pattern_problem(self.family, optional=("word", "number"))
        if has_syntax(self.family):
            expected = f"give text, such as pair{{number}}_{{word}}|seg{{number}}; {_NOT_REGULAR}"
        if expected:
            yield "family", self.family, expected


@dataclass
class PressureNameConfig:
    """A pattern that extracts the commanded pressure from a file name."""

    pattern: str = ""  # text with {number}, such as {number}kPa
    unit: str = quantity("kPa", known=tuple(PRESSURE))

    def violations(self) -> Iterator[Violation]:
        yield from _number_violations(self.pattern)


@dataclass
class LoadNameConfig:
    """A pattern that extracts the mass of a load at the tip from a file name; no match means no load."""

    pattern: str = ""  # text with {number}, g, such as load_{number}g
    masses: dict[str, float] = quantity({}, "kg", above=0)  # true masses by that number, if it is not exact

    def violations(self) -> Iterator[Violation]:
        yield from _number_violations(self.pattern)


@dataclass
class InstrumentConfig:
    """An instrument beside the finger's sensors, which measures at a position along the finger."""

    column: str = quantity("", filled=True)
    place: float | None = quantity(None, "m", least=0)  # from the base along the finger
    place_column: str | None = quantity(None, filled=True)  # of places that change
    place_unit: str = quantity("m", known=tuple(LENGTH))  # of that column
    sign: int = 1  # -1: the instrument counts the other way

    def violations(self) -> Iterator[Violation]:
        if (self.place is None) == (self.place_column is None):
            yield "place", self.place, "give either it or `place_column`"
        if self.sign not in (1, -1):
            yield "sign", self.sign, "must be 1 or -1"

    @property
    def columns(self) -> list[str]:
        """Columns of the instrument's readings and, if it moves, of its position."""
        return [self.column, *([] if self.place_column is None else [self.place_column])]


@dataclass
class MeasuredForceConfig(InstrumentConfig):
    """A force on the finger, N, such as that on a scale; positive if it presses on the inner side."""

    unit: str = quantity("N", known=tuple(FORCE))  # gf: what a kitchen scale calls g
    # Direction, x and z in B, in which it is measured; None: across the finger where it presses
    along: list[float] | None = quantity(None, length=2)

    def violations(self) -> Iterator[Violation]:
        yield from super().violations()
        if self.along is not None and not any(self.along):
            yield "along", self.along, "must be a direction; it may not be zero"


@dataclass
class MeasuredTorqueConfig(InstrumentConfig):
    """Moment of the contacts beyond a position about it, across the bending plane; positive if it closes the finger."""

    unit: str = quantity("N m", known=tuple(TORQUE))


@dataclass
class MeasuredAngleConfig(InstrumentConfig):
    """Angle between the base and a position along the finger; positive if it closes."""

    unit: str = quantity("rad", known=tuple(ANGLE))


_NOT_REGULAR = "regular expressions are not read"


def _number_violations(pattern: str) -> Iterator[Violation]:
    plain_pattern = plain_number_pattern(pattern)
    expected = pattern_problem(plain_pattern, ("number",))
    if has_syntax(plain_pattern):
        expected = f"give text with {{number}}, such as _{{number}}g; {_NOT_REGULAR}"
    if expected:
        yield "pattern", pattern, expected


def _scale_violations(unit: str, scale: float | None) -> Iterator[Violation]:
    if (unit == "V") != (scale is not None):
        yield "scale", scale, "must be given if and only if the unit is V"


@dataclass
class RecordingConfig:
    """The contents of the files of one experiment."""

    description: str = ""
    source: SourceConfig | None = None
    header: list[str] | None = None  # column names of text; None: they are in the file
    text: TextConfig = field(default_factory=TextConfig)
    time: str = "time"  # column
    time_unit: str | None = quantity(None, known=tuple(TIME))  # None: s, unless the samples are too close or far apart
    length: float = quantity(0.1, "m", above=0)  # approximate length of the straight finger, used to check units
    finger: str | None = None  # URDF with the finger that models it: package:// URI, or path relative to this file
    markers: MarkersConfig | None = None
    poses: dict[str, PoseConfig] = field(default_factory=dict)  # by rigid body: "base", "tip", ...
    pressures: PressuresConfig | None = None
    # Of strain sensors, in the order of the readings of a scenario, strain or counts; for `calibrate` and `replay`
    readings: list[str] = field(default_factory=list)
    lengths: LengthsConfig | None = None
    tendons: TendonsConfig | None = None
    measured_force: MeasuredForceConfig | None = None
    measured_torque: MeasuredTorqueConfig | None = None
    measured_angle: MeasuredAngleConfig | None = None
    labels: LabelsConfig | None = None
    frame: FrameConfig = field(default_factory=FrameConfig)
    # Age up to which the last value of a signal counts in rows without one, where signals have rates of their own;
    # None: 0.1 for the topics of a bag, none for the columns of a table
    hold: float | None = quantity(None, "s", above=0)
    # A gap of time that is longer, or time that begins anew, begins another run; None: a file is one run
    pause: float | None = quantity(None, "s", above=0)
    every: int = quantity(1, least=1)  # of so many rows of settled states one is used
    blocks: int = quantity(
        1, least=1
    )  # settled states without labels: spans of equal length, left out of a fit in turn
    gravity: list[float] | None = quantity(None, "m/s^2", length=3)  # in the axes of the recording; None: unknown
    # Initial period in which the finger is straight or held; of a step, as long a one just before it counts
    reference: float = quantity(0.3, "s", above=0)
    # "release": a hand lets go; "step": a valve opens and closes; both at unknown times. "settled": each row is at rest
    event: str | None = quantity(None, known=("release", "step", "settled"))
    commanded_pressure: list[PressureNameConfig] = field(default_factory=list)  # the first that fits
    load: LoadNameConfig | None = None
    # x and z of the load from the tip in the tip's frame; None: unknown
    load_place: list[float] | None = quantity(None, "m", length=2)
    load_string: float | None = quantity(None, "m", above=0)  # on which it swings; None: it is fixed to the tip
    unknown: list[str] = field(default_factory=list)  # other information missing from the recording, as text

    @property
    def time_scale(self) -> float:
        """Length of the unit of time, s."""
        return TIME[self.time_unit or "s"]

    @property
    def columns(self) -> dict[str, str]:
        """Described columns of numbers, without the time, each with the field that names it."""
        fields = dict.fromkeys(self.readings, "readings")
        if self.markers is not None:
            names = [name for body in self.markers.bodies.values() for name in body]
            fields |= dict.fromkeys((column for name in names for column in self.markers.column_names(name)), "markers")
        for body, pose in self.poses.items():
            fields |= dict.fromkeys(pose.position, f"poses.{body}.position")
            fields |= dict.fromkeys(pose.quaternion, f"poses.{body}.quaternion")
        if self.pressures is not None:
            fields |= dict.fromkeys(self.pressures.columns, "pressures.columns")
        if self.lengths is not None:
            fields |= dict.fromkeys((wire.column for wire in self.lengths.wires.values()), "lengths.wires")
        if self.tendons is not None:
            fields |= dict.fromkeys(self.tendons.columns.values(), "tendons.columns")
            fields |= dict.fromkeys(self.tendons.antagonists.values(), "tendons.antagonists")
        return fields | instrument_columns(self)

    def violations(self) -> Iterator[Violation]:
        header = self.header or []
        if twice := sorted({name for name in header if header.count(name) > 1}):
            yield "header", twice, "column names must be unique"


AnyInstrument = MeasuredForceConfig | MeasuredTorqueConfig | MeasuredAngleConfig
KINDS = ("force", "torque", "angle")  # quantities of instruments


def instruments(described: object) -> dict[str, AnyInstrument]:
    """Instruments of a description with fields `measured_force` and so on, by their quantity."""
    configs = {kind: getattr(described, f"measured_{kind}") for kind in KINDS}
    return {kind: config for kind, config in configs.items() if config is not None}


def instrument_columns(described: object, prefix: str = "") -> dict[str, str]:
    """Columns of the instruments of a description, each with the field that names it, after a prefix."""
    return {
        column: f"{prefix}measured_{kind}"
        for kind, config in instruments(described).items()
        for column in config.columns
    }


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
        shipped_names = description_names()
        if str(name_or_path) not in shipped_names:
            expected = f"not shipped; known: {', '.join(shipped_names)}; or give a path"
            raise InputError("recording", "--as", str(name_or_path), expected)
    config = load_config(path, read_yaml(path), RecordingConfig)
    if config.finger is not None and not config.finger.startswith("package://"):
        config.finger = os.path.realpath(path.parent / config.finger)
    return config
