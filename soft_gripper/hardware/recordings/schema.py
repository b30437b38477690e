"""The whole schema of the description of a hardware recording, on one page. Columns are given by their names.

A field that may be left out, and then means that there is no such thing, is None.
"""

from dataclasses import dataclass, field


@dataclass
class SourceConfig:
    """Where the recording can be had."""

    repository: str = ""
    path: str = ""
    license: str = ""


@dataclass
class FrameConfig:
    """The finger's frame B in the axes of the recording."""

    # m, of the base of the finger; None: where the body "base" is in the mean over the reference
    origin: list[float] | None = None
    z: list[float] = field(default_factory=lambda: [0.0, 0.0, 1.0])  # along the straight finger; any length
    x: list[float] = field(default_factory=lambda: [1.0, 0.0, 0.0])  # toward the inner side; made normal to z


@dataclass
class MarkersConfig:
    """Markers and the bodies they are glued to. A C3D file names its points as the markers, and says its unit."""

    columns: str = "{marker}_{axis}"  # of a table, with x, y and z for the axis
    unit: str = "m"  # of those columns: m, cm or mm
    bodies: dict[str, list[str]] = field(default_factory=dict)  # markers by rigid body: "base", "tip"; empty: none


@dataclass
class PoseConfig:
    """The pose of a rigid body, as motion capture reports it."""

    position: list[str] = field(default_factory=list)  # columns of x, y, z
    quaternion: list[str] = field(default_factory=list)  # columns of w, x, y, z, in this order
    unit: str = "m"  # of the position


@dataclass
class PressuresConfig:
    """Measured pressures, one column a chamber."""

    columns: list[str] = field(default_factory=list)
    sections: list[int] | None = None  # that each chamber is in, counted from the base; None: not said
    unit: str = "Pa"  # Pa, hPa, mbar, kPa, bar, psi or V
    scale: float | None = None  # Pa per V, where the unit is V


@dataclass
class WireConfig:
    """A length sensor along one side of the finger, from its base to the end of a section."""

    column: str = ""
    side: str = "inner"  # or "outer"
    section: int = 1  # at whose end it is fixed, counted from the base


@dataclass
class LengthsConfig:
    """Length sensors, each with a constant offset that may be unknown."""

    wires: dict[str, WireConfig] = field(default_factory=dict)
    unit: str = "m"  # m, cm, mm or V
    scale: float | None = None  # m per V, where the unit is V
    spacing: float = 0.0  # m, between the inner and the outer side


@dataclass
class PressureNameConfig:
    """A way to read the commanded pressure from a file's name."""

    pattern: str = ""  # regular expression whose one group is the number
    unit: str = "kPa"


@dataclass
class LoadNameConfig:
    """How a load that hangs on the tip is read from a file's name; a name without it has none."""

    pattern: str = ""  # regular expression whose one group is the number, g
    masses: dict[str, float] = field(default_factory=dict)  # kg, true masses by that number, where it is not exact


@dataclass
class RecordingConfig:
    """What the files of one experiment hold."""

    description: str = ""
    source: SourceConfig | None = None
    header: list[str] | None = None  # names of the columns; None: the first row of the file has them
    time: str = "time"  # column
    time_unit: str = "s"  # or ms
    length: float = 0.1  # m, of the straight finger, roughly: what decides whether units can be right
    finger: str | None = None  # URDF with the finger that stands for it: package:// URI, or path beside this file
    markers: MarkersConfig | None = None
    poses: dict[str, PoseConfig] = field(default_factory=dict)  # by rigid body: "base", "tip", ...
    pressures: PressuresConfig | None = None
    lengths: LengthsConfig | None = None
    frame: FrameConfig = field(default_factory=FrameConfig)
    gravity: list[float] | None = None  # m/s^2, in the axes of the recording; None: unknown
    reference: float = 0.3  # s from the beginning, in which the finger is straight or held
    event: str | None = None  # "release": a hand lets go; "step": a valve opens and closes; both at unknown times
    commanded_pressure: list[PressureNameConfig] = field(default_factory=list)  # the first that fits
    load: LoadNameConfig | None = None
    load_place: list[float] | None = None  # m, x and z of the load from the tip in the tip's frame; None: unknown
    unknown: list[str] = field(default_factory=list)  # what else the recording does not say, in words
