"""The schema of a calibration file."""

from dataclasses import dataclass, field


@dataclass
class FingerCalibrationConfig:
    """What was found of one finger, relative to what was believed of it, and which finger it was."""

    length: float = 0.0  # m
    sensor_spacing: float = 0.0  # m
    one_sided: bool = False
    section_lengths: list[float] = field(default_factory=list)  # m, from the base to the tip
    bend_ratio: float = 1.0  # how much further it bends under the same pressure than was believed
    gains: list[float] = field(default_factory=list)  # of the strain of every reading
    offsets: list[float] = field(default_factory=list)  # of every reading, extension ratio
    residual: float = 0.0  # root mean square of what is left, extension ratio


@dataclass
class CalibrationConfig:
    """A calibration of the fingers of a gripper, by their names."""

    assumed: str = ""  # in words
    fingers: dict[str, FingerCalibrationConfig] = field(default_factory=dict)
