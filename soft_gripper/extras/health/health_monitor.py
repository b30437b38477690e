"""HealthMonitor: the health of a finger and its sensors as a block, and as lines of `soft-gripper run`."""

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.estimation import usable
from soft_gripper.errors import InputError
from soft_gripper.estimators.calibration_range import FAR
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.plane import to_base
from soft_gripper.extras.health.faults import FAULTS
from soft_gripper.extras.health.health_filter import FilterMemory, HealthFilter
from soft_gripper.scenario.schema import EstimatorConfig, SensorConfig
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.sensors.measurement import MeasurementModel

NAMING_PROBABILITY = 0.95  # minimum of a fault that is named, and of a sensor that is dropped


def make_monitor(
    layout: MeasurementModel, config: EstimatorConfig, sensor: SensorConfig, gravity: Array
) -> "HealthMonitor":
    """Makes the monitor of a finger from parts of a scenario; `gravity` in the world, m/s^2.

    Raises:
        InputError: if the finger leaves its plane, or no pressure bends it.
    """
    return HealthMonitor(HealthFilter(layout, uncertainty(config, sensor, layout.calibrated), sensor.period), gravity)


class HealthMonitor(ArrayBlock):
    """Names the fault of one finger or of its sensors, and drops the readings of a faulty sensor.

    ::

        strain (R) ---------------> +---------------+ ---> fault_probabilities  (8), see `faults.FAULTS`
        driving_torque (N) N m ---> | HealthMonitor | ---> fault                (1) 0 healthy, 1 dead ... 7 held
        X_WB (12) [R | p] --------> |               | ---> sensor_fault         (R) probability that a sensor is faulty
                                    +---------------+ ---> usable_strain        (R) readings, NaN of a faulty sensor

    `strain` holds the readings, and is named after the sensors' quantity. Give it inputs that are sampled together
    every period of its function, from time 0, in discrete state.
    """

    takes_axes = False  # the filter has an axis of hypotheses, and follows one finger

    def __init__(self, function: HealthFilter, gravity: Array):
        """`gravity` in the world, (3,) m/s^2, zero for none.

        Raises:
            InputError: if the finger leaves its plane, or no pressure bends it.
        """
        check_monitored(function)
        super().__init__(function.period)
        layout = function.layout
        start = function.begin()
        self.function = function
        self.take(layout.quantity, layout.readings)
        self.take(DRIVING_TORQUE, layout.finger.segments)
        self.take("X_WB", 12)
        self.derive("gravity", lambda X_WB: to_base(X_WB, gravity), "X_WB")
        self.remember(
            "memory",
            lambda memory, *sample: function.step(_unflatten(memory, start), *sample),
            *(layout.quantity, DRIVING_TORQUE, "gravity"),
            begin=_flatten(start),
            keep=_flatten,
        )
        self.derive("probabilities", function.probabilities, "memory")
        self.derive("sensor_probabilities", function.sensor_probabilities, "memory")
        self.put_out("fault_probabilities", lambda probabilities: probabilities, "probabilities", fault=FAULTS)
        self.put_out("fault", named_fault, "probabilities", meanings=FAULTS)
        self.put_out(
            "sensor_fault", lambda probabilities: probabilities, "sensor_probabilities", unit="1", **layout.axes
        )
        self.derive(
            "usable",
            lambda probabilities, readings: np.where(probabilities < NAMING_PROBABILITY, readings, np.nan),
            "sensor_probabilities",
            layout.quantity,
        )
        name = usable(layout.quantity)
        self.put_out(name, lambda readings: readings, "usable", unit=layout.unit, **layout.axes)


def named_fault(probabilities: Array) -> Array:
    """Index in FAULTS of the named fault, (...): the most probable one, once a fault is nearly certain."""
    most_probable: Array = 1.0 + probabilities[..., 1:].argmax(axis=-1)
    return np.where(probabilities[..., 0] < 1 - NAMING_PROBABILITY, most_probable, 0.0)


def named_faults(station: Station, recording: Recording) -> list[str]:
    """Lines on fingers with a fault named at the end, its beginning, and readings far from a calibration."""
    lines = []
    for finger in station.fingers:
        name = f"{finger.name}.fault"
        if name in recording.data and (fault := int(recording[name].values[-1])):
            probability = recording[f"{finger.name}.fault_probabilities"].values[-1, fault]
            onset_time = recording["time"].values[recording[name].values.ravel() == 0].max(initial=0.0)
            lines.append(f"{finger.name}: {FAULTS[fault]} ({probability:.0%}), since {onset_time:.2f} s")
        if name in recording.data and f"{finger.name}.{FAR}" in recording.data:
            share = float(recording[f"{finger.name}.{FAR}"].values.mean())
            if share:
                lines.append(f"{finger.name}: {share:.0%} of the run is far from its calibration, where less is known")
    return lines


def check_monitored(function: HealthFilter) -> None:
    """Raises an InputError if the finger leaves its plane, or no pressure bends it."""
    layout = function.layout
    if layout.deformations != ("bending",) or not np.any(layout.finger.pressure_gain):
        expected = "works for fingers that bend in their plane, by pressure; set it to false"
        raise InputError("estimator", "health", True, f"{expected} (finger '{layout.finger.name}')")


def _flatten(memory: FilterMemory) -> Array:
    """Puts all fields of a memory in a row, (n,)."""
    return np.concatenate([np.ravel(field) for field in memory])


def _unflatten(numbers: Array, like: FilterMemory) -> FilterMemory:
    """Inverts `_flatten`, with the field sizes of another memory."""
    ends = np.cumsum([np.size(part) for part in like])[:-1]
    pairs = zip(np.split(numbers, ends), like, strict=True)
    return FilterMemory._make(part.reshape(np.shape(field)) for part, field in pairs)
