"""What a scenario may say, and reading it."""

from .calibration_file import load_calibration as load_calibration
from .calibration_file import save_calibration as save_calibration
from .nominal_model import NominalModel as NominalModel
from .nominal_model import read_nominal_model as read_nominal_model
from .scenario import DeadSensorConfig as DeadSensorConfig
from .scenario import FingerConfig as FingerConfig
from .scenario import MeshConfig as MeshConfig
from .scenario import NominalConfig as NominalConfig
from .scenario import PhaseConfig as PhaseConfig
from .scenario import PoseErrorConfig as PoseErrorConfig
from .scenario import StrainErrorsConfig as StrainErrorsConfig
from .scenario import TrialsConfig as TrialsConfig
from .sensor_presets import sensor_layout as sensor_layout
from .sensor_presets import strain_errors as strain_errors
