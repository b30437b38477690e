"""Schema of a bench in YAML: the source of its readings, the meaning of its fields, and the sink of the results.

An optional field that is omitted is None: there is no such item. A new option is a field of `BenchConfig`.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.recording_schema import (
    PRESSURE,
    MeasuredAngleConfig,
    MeasuredForceConfig,
    MeasuredTorqueConfig,
    instrument_columns,
)
from soft_gripper.files.document import load_config, require
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.quantity import Violation, quantity

FORMATS = ("json", "text", "float32", "float64")


@dataclass
class BenchFinger:
    """Measurements of one finger: names of fields, each of which is a number of every message."""

    readings: list[str] = quantity([], filled=True)  # of the sensors, in the order of the scenario's readings
    pressures: list[str] = field(default_factory=list)  # in the chambers
    tensions: list[str] = field(default_factory=list)  # of the tendons, N
    # Of the base in the world: R row by row, then p, m; None: it stays where the scenario begins
    base_pose: list[str] | None = quantity(None, length=12)
    # Of the tip, x and z in the frame of the base, m, measured apart; in logs for `soft-gripper calibrate` alone
    tip: list[str] | None = quantity(None, length=2)
    # Of instruments beside the sensors: recorded by `live`, and compared with estimates by `replay`
    measured_force: MeasuredForceConfig | None = None
    measured_torque: MeasuredTorqueConfig | None = None
    measured_angle: MeasuredAngleConfig | None = None


@dataclass
class BenchConfig:
    """A bench: hardware that sends its readings at the period of the scenario's sensors."""

    source: str = quantity("", filled=True)  # an address, see docs/extras/bench/live.md
    sink: str | None = None  # likewise; None: results go to standard output
    format: str = quantity("json", known=FORMATS)  # of the messages
    sink_format: str | None = quantity(None, known=FORMATS)  # of the results; None: the same
    fields: list[str] = field(default_factory=list)  # in the order of a message without names: text, float32, float64
    count: str | None = None  # field that numbers the messages; None: losses cannot be detected
    time: str | None = None  # field with the time of the device, s, which is returned with the results
    fingers: dict[str, BenchFinger] = quantity({}, filled=True)  # by the names of the scenario's fingers
    pressure_unit: str = quantity("Pa", known=tuple(PRESSURE))  # of measured and commanded pressures
    pressure_ambient: float | None = None  # what is measured in open air, in the unit above; None: 0
    # Measurements outside are malformed; None: far beyond what the scenario's sensors and drive can do
    reading_range: list[float] | None = quantity(None, span=True)  # of every sensor, in its own unit
    pressure_range: list[float] | None = quantity(None, span=True)  # in the unit above
    tension_range: list[float] | None = quantity(None, "N", span=True)
    # Of a log: a gap of time that is longer, or time that begins anew, begins another run; None: it is one run
    pause: float | None = quantity(None, "s", above=0)
    # Of a log: as `hold` of a recording
    hold: float | None = quantity(None, "s", above=0)
    opening: str | None = None  # field with the set point of the opening, m; None: those of the scenario
    send: list[str] | None = None  # signals of the results, "{finger}.{signal}"; None: those of shape and contact
    record: list[str] | None = None  # signals of a recording beside those measured, sent and commanded; None: likewise
    stale_after: float = quantity(0.04, "s", above=0)  # without a reading, commands are safe and bands widen
    safe_command: float = 0.0  # Pa, or N or m of tendons: what every finger is commanded then

    @property
    def pressure_factor(self) -> float:
        """Unit of the pressures, Pa."""
        return PRESSURE[self.pressure_unit]

    def relative(self, pressure: Array) -> Array:
        """Measured pressures, in their unit, relative to the surroundings, Pa."""
        with np.errstate(over="ignore"):  # an infinite pressure is not plausible, see `plausible`
            return self.pressure_factor * (pressure - (self.pressure_ambient or 0.0))

    @property
    def names(self) -> list[str]:
        """Fields of a message that are used."""
        finger_names = [
            name
            for finger in self.fingers.values()
            for name in (
                *(*finger.readings, *finger.pressures, *finger.tensions, *(finger.base_pose or ())),
                *instrument_columns(finger),
            )
        ]
        return [*finger_names, *(name for name in (self.count, self.time, self.opening) if name is not None)]

    def violations(self) -> Iterator[Violation]:
        twice = sorted({name for name in self.names if self.names.count(name) > 1})
        if twice:
            yield "fingers", twice, "each field has one meaning"
        yield from _line_violations("source", self.source, self.format)
        yield from _line_violations("sink", self.sink or "stdio:", self.sink_format or self.format)
        if self.format == "json":
            return
        for name in self.names:
            if name not in self.fields:
                yield "fields", self.fields, f"must have '{name}': a message of format {self.format} has no names"


def _line_violations(field_: str, address: str, form: str) -> Iterator[Violation]:
    scheme = address.partition(":")[0]
    if form not in ("json", "text") and scheme in ("serial", "stdio", "file"):
        yield field_, address, f"carries lines, and {form} has none: take json or text there"


def load_bench(file: Path) -> BenchConfig:
    """Reads the description in a YAML file."""
    require(file.is_file(), file, "bench", str(file), "there is no such file")
    return load_config(file, read_yaml(file), BenchConfig)


def bench_from_inputs(inputs: Mapping[str, int], source: str) -> BenchConfig:
    """Describes a bench whose messages name the inputs of a `Bench`, `{finger}.{kind}`, by their sizes."""
    fields: dict[str, dict[str, list[str]]] = {}
    for name, size in inputs.items():
        finger, _, kind = name.rpartition(".")
        fields.setdefault(finger, {})[kind] = [f"{name}[{i}]" for i in range(size)]
    fingers = {}
    for finger, kind_columns in fields.items():
        pressures, tensions, pose = (kind_columns.pop(kind, []) for kind in ("pressure", "tension", "X_WB"))
        (readings,) = kind_columns.values()
        fingers[finger] = BenchFinger(readings, pressures, tensions, pose or None)
    return BenchConfig(source=source, count="count", time="time", fingers=fingers)
