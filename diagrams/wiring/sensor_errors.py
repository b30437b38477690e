"""The errors of sensors, applied: the parts of a scenario that say so -> blocks, or none."""

from pydrake.systems.framework import System

from soft_gripper.diagrams.schema.scenario import SensorConfig
from soft_gripper.diagrams.schema.sensor_presets import pressure_errors, strain_errors
from soft_gripper.diagrams.wiring.named_wires import vector_outputs
from soft_gripper.errors import InputError
from soft_gripper.sensors.error_block import ErrorBlock
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_error_block import StrainErrorBlock
from soft_gripper.signals import describe

IDEAL = "ideal_"  # begins the names of signals as they were without errors; estimation cannot ask for them


def strain_error_block(sensor: System, layout: SensorLayout, config: SensorConfig) -> StrainErrorBlock | None:
    """What disturbs the readings of a sensor of that layout; None if nothing does.

    Raises:
        InputError: if an error is wrong, or the sensor puts out other readings than the layout has.
    """
    errors = strain_errors(config)
    if errors is None:
        return None
    outputs = vector_outputs(sensor)
    sizes = {name: port.size() for name, port in outputs.items()}
    if sizes.get("strain") != layout.readings:
        expected = f"put out 'strain' ({layout.readings}), the readings, which sensor.errors disturb"
        raise InputError("sensor", "output ports", sizes, expected)
    return StrainErrorBlock(layout, errors, config.period)


def pressure_error_block(config: SensorConfig) -> ErrorBlock | None:
    """What disturbs the sampled pressure; None if nothing does.

    Raises:
        InputError: if an error is wrong.
    """
    errors = pressure_errors(config)
    if errors is None:
        return None
    block = ErrorBlock(errors, 1, config.period, f"{IDEAL}pressure", "sampled_pressure")
    describe(block.get_output_port(), "Pa")
    return block
