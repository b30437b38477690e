"""Sensors: joint angles -> readings."""

from .base_pose import BasePoseSensor as BasePoseSensor
from .measurement import MeasurementModel as MeasurementModel
from .pressure_errors import PressureErrors as PressureErrors
from .sensor_block import SensorBlock as SensorBlock
from .sensor_layout import SensorLayout as SensorLayout
from .sensor_layout import extension_ratios as extension_ratios
from .strain_errors import Draws as Draws
from .strain_errors import StrainErrors as StrainErrors
from .strain_errors import disturb as disturb
