"""The sensors that a finger could have, and designs made of them.

A finger that stays in its plane has strain sensors on its sides, as the scenario says, whose sections end anywhere. For
one that leaves it a design is of one kind, as a scenario's sensors are: strain along some of the paths of `PATHS`,
gratings on the neutral axis, or inertial sensors. One sensor is one reading of strain, or one place where a grating or
an inertial sensor sits, which gives a reading for every way in which the finger turns, or three.

The errors of strain sensors are those of a preset. Those of the other kinds are rounded choices of ours.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.schema import SensorConfig, SensorPathConfig, StrainErrorsConfig
from soft_gripper.sensors.path_sensors import outermost

STRAIN, CURVATURE, ORIENTATION = KINDS = ("strain", "curvature", "orientation")


class Course(NamedTuple):
    """Course of a path, in units of the distances of the outermost sensors from the middle of the section."""

    x: tuple[float, ...]
    y: tuple[float, ...]
    x_slope: float = 0.0  # of short strands side by side
    y_slope: float = 0.0


def _bands() -> dict[str, Course]:
    """Strands at 45 degrees in the middles of the faces, either way."""
    across = {"inner": Course((1,), (0,), 0, 1), "outer": Course((-1,), (0,), 0, 1)}
    across |= {"left": Course((0,), (1,), 1, 0), "right": Course((0,), (-1,), 1, 0)}
    rising = {f"{face}_rising": course for face, course in across.items()}
    falling = {
        f"{face}_falling": course._replace(x_slope=-course.x_slope, y_slope=-course.y_slope)
        for face, course in across.items()
    }
    return rising | falling


PATHS = {
    "inner": Course((1,), (0,)),
    "outer": Course((-1,), (0,)),
    "left": Course((0,), (1,)),
    "right": Course((0,), (-1,)),
    "inner_left": Course((1,), (1,)),
    "inner_right": Course((1,), (-1,)),
    "outer_left": Course((-1,), (1,)),
    "outer_right": Course((-1,), (-1,)),
    **_bands(),
    "inner_slanted": Course((1, 1), (-1, 1)),  # from edge to edge, over the whole length
    "outer_slanted": Course((-1, -1), (-1, 1)),
    "left_helix": Course((-1, -1, 1, 1, -1), (-1, 1, 1, -1, -1)),  # once around the finger
    "right_helix": Course((-1, -1, 1, 1, -1), (1, -1, -1, 1, 1)),
}

_OTHER_KINDS = {
    CURVATURE: StrainErrorsConfig(noise=0.1, gain_error=0.01),  # rad/m, share
    ORIENTATION: StrainErrorsConfig(noise=0.005, offset=0.01),  # rad
}


def errors_of(kind: str, preset: str | None) -> StrainErrorsConfig | None:
    """Errors of sensors of a kind, strain sensors being of a preset; None: all are ideal."""
    if preset is None:
        return None
    return _OTHER_KINDS.get(kind) or StrainErrorsConfig(preset=preset)


@dataclass(frozen=True, order=True)
class Design:
    """Sensors of one kind."""

    kind: str
    borders: tuple[float, ...]  # between sections, as shares of the length
    paths: tuple[str, ...] = ()  # of strain; none: those on the sides

    @property
    def sensors(self) -> int:
        """How many there are; of those on the sides, on each."""
        return (len(self.borders) + 1) * max(len(self.paths), 1)

    def config(self, finger: Finger, like: SensorConfig, errors: StrainErrorsConfig | None = None) -> SensorConfig:
        """As a scenario describes it, whose sensors are otherwise `like` these if they are on the sides."""
        sections, borders = len(self.borders) + 1, list(self.borders) or None
        if not leaves_its_plane(finger):
            return replace(like, sections=sections, borders=borders, errors=errors)
        paths = [_path(name, finger) for name in self.paths]
        return SensorConfig(self.kind, sections, borders, paths=paths, errors=errors)

    @property
    def where(self) -> str:
        """The borders as text for tables."""
        return " ".join(f"{border:.4g}" for border in self.borders) or "none"


def leaves_its_plane(finger: Finger) -> bool:
    """Whether it twists, as all do that bend sideways."""
    return "twist" in finger.yields


def _path(name: str, finger: Finger) -> SensorPathConfig:
    """In whole tenths of a millimetre, as it can be built."""
    (x, y), course = outermost(finger), PATHS[name]
    stations = max(len(course.x), len(course.y), 2)
    at = [i / (stations - 1) for i in range(stations)]
    return SensorPathConfig(
        name,
        [round(i * x, 4) for i in course.x],
        [round(j * y, 4) for j in course.y],
        at,
        course.x_slope,
        course.y_slope,
    )


def as_borders(ends: tuple[int, ...], finger: Finger) -> tuple[float, ...]:
    """Shares of the length, of ends of segments, to four digits."""
    return tuple(round(end / finger.segments, 4) for end in ends)


def divisions(finger: Finger, most: int) -> list[tuple[int, ...]]:
    """Ends of 1 to `most` sections but the last: equal ones, and such that are shorter toward the base."""
    found: dict[tuple[int, ...], None] = {}
    for sections in range(1, min(most, finger.segments) + 1):
        for power in (1.0, 1.5):
            ends = tuple(round((i / sections) ** power * finger.segments) for i in range(1, sections))
            if len({0, *ends, finger.segments}) == sections + 1:
                found[ends] = None
    return list(found)
