"""The health of fingers and sensors: faults named with a probability, and faulty sensors dropped."""

from .faults import FAULTS as FAULTS
from .health_filter import HealthFilter as HealthFilter
from .health_monitor import HealthMonitor as HealthMonitor
