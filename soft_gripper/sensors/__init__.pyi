"""Sensors: joint angles -> readings."""

from .base_pose import BasePoseSensor as BasePoseSensor
from .base_pose import FixedBasePose as FixedBasePose
from .error_block import ErrorBlock as ErrorBlock
from .error_block import ErrorModel as ErrorModel
from .link_sensors import CurvatureSensors as CurvatureSensors
from .link_sensors import OrientationSensors as OrientationSensors
from .measurement import LinearReadings as LinearReadings
from .measurement import MeasurementModel as MeasurementModel
from .observability import Observed as Observed
from .observability import observability as observability
from .path_sensors import PathSensors as PathSensors
from .path_sensors import SensorPath as SensorPath
from .pressure_errors import PressureErrors as PressureErrors
from .pressure_errors import disturb_pressure as disturb_pressure
from .response_curve import CalibratedResponse as CalibratedResponse
from .response_curve import ResponseCurve as ResponseCurve
from .sensor_block import SensorBlock as SensorBlock
from .sensor_layout import SensorLayout as SensorLayout
from .sensor_layout import extension_ratios as extension_ratios
from .strain_errors import Draws as Draws
from .strain_errors import ReadingErrorBlock as ReadingErrorBlock
from .strain_errors import StrainErrors as StrainErrors
from .strain_errors import disturb as disturb
