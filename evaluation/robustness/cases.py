"""What the maps of robustness go through: how much the sensors err, and what is believed wrongly."""

from dataclasses import dataclass, replace

import numpy as np

from soft_gripper.diagrams.schema.scenario import BelievedConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.diagrams.schema.sensor_presets import strain_errors
from soft_gripper.sensors.strain_errors import StrainErrors

PRESET = "realistic"
NOISES = (0.0, 1.0, 2.0, 4.0)  # times the errors of the preset
_SIZES = ("creep", "hysteresis", "gain_error", "offset", "drift", "low_frequency_noise", "noise")


@dataclass(frozen=True)
class Belief:
    """By which shares what is believed differs from the truth."""

    modulus: float = 0.0  # of Young's modulus of the silicone
    pressure: float = 0.0  # of the measured pressure

    @property
    def name(self) -> str:
        """In tables."""
        parts = ("E", self.modulus), ("p", self.pressure)
        return ", ".join(f"{what} {100 * share:+.0f} %" for what, share in parts if share) or "as simulated"

    @property
    def size(self) -> float:
        """Of both together: the share by which the bend per pressure may be wrong."""
        return float(np.hypot(self.modulus, self.pressure))

    @property
    def config(self) -> BelievedConfig:
        """As a scenario says it."""
        change = None if self.modulus == 0 else f"{100 * self.modulus:+g} %"
        return BelievedConfig(youngs_modulus=change)


# Too soft a finger and too high a pressure both promise too much bend: the signs are those that add up.
BELIEFS = (Belief(), Belief(-0.1, 0.01), Belief(0.1, -0.01))


def errors_at(noise: float) -> StrainErrors | None:
    """The errors of sensors that err so many times as much as the preset; None without."""
    preset = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=PRESET)))
    if preset is None or noise == 0:
        return None
    return replace(preset, **{name: noise * getattr(preset, name) for name in _SIZES})
