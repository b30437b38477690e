"""A recording of hardware, as arrays."""

from dataclasses import dataclass, field

from soft_gripper.arrays import Array
from soft_gripper.hardware.recordings.body_poses import BodyPose
from soft_gripper.hardware.recordings.schema import RecordingConfig


@dataclass(frozen=True)
class HardwareRecording:
    """What one file holds, in SI units and, where it has a direction, in the finger's frame B. NaN: not seen."""

    name: str  # of the file, without its suffix
    config: RecordingConfig  # how the file is described: bodies, wires, event and what is unknown
    time: Array  # (T,) s, increasing
    markers: dict[str, Array] = field(default_factory=dict)  # (T, 3) m, by name
    reference: dict[str, Array] = field(default_factory=dict)  # (3,) m, mean of every marker over the reference span
    poses: dict[str, BodyPose] = field(default_factory=dict)  # by rigid body
    pressures: Array | None = None  # (T, C) Pa, measured, in the order of the description
    lengths: dict[str, Array] = field(default_factory=dict)  # (T,) m, by wire
    commanded_pressure: float | None = None  # Pa, from the file's name
    load_mass: float = 0.0  # kg, hung on the tip, from the file's name
    load_place: tuple[float, float] | None = None  # m, x and z of the load from the tip; None: unknown
    gravity: Array | None = None  # (3,) m/s^2; None: unknown
    gaps: tuple[str, ...] = ()  # what is missing or was left out, in words
