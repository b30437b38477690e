"""What a scenario may say, and reading it."""

from .calibration_file import load_calibration as load_calibration
from .schema import DeadSensorConfig as DeadSensorConfig
from .schema import MeshConfig as MeshConfig
from .schema import NominalConfig as NominalConfig
from .schema import PhaseConfig as PhaseConfig
from .schema import PoseErrorConfig as PoseErrorConfig
from .schema import StrainErrorsConfig as StrainErrorsConfig
from .schema import UncertaintyConfig as UncertaintyConfig
from .sensor_presets import sensor_layout as sensor_layout
from .sensor_presets import strain_errors as strain_errors
