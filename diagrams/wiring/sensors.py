"""The sensors of a finger, applied: joint angles and pressure -> readings."""

from pydrake.common import RandomDistribution
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import MatrixGain, RandomSource

from soft_gripper.diagrams.wiring.composed import PartPorts, add_part
from soft_gripper.diagrams.wiring.named_wires import NamedWires, Ports, add_stage, connect_by_name, vector_outputs
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.registry import blamed_on, make_block, name_of
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import SENSORS, MakeSensor, is_measurement_model, sensor_layout, strain_errors
from soft_gripper.sensors.base_pose import BasePoseSensor, FixedBasePose
from soft_gripper.sensors.error_block import ErrorBlock
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_block import Hold, SensorBlock, StrainSensor, joints_port
from soft_gripper.sensors.sensor_layout import measures_strain
from soft_gripper.sensors.strain_errors import ReadingErrorBlock
from soft_gripper.signals import describe

RANDOM = ".random"  # suffix of the inputs of random numbers, and of their sources
IDEAL = "ideal_"  # prefix of error-free signals; estimation has no access to them


class FingerSensors(Diagram):
    """Makes all measurements on one finger.

    ::

        joint_angles (N) rad ---> sensor ------------> strain (or another quantity), and any other outputs of the sensor
        pressure (C) Pa --------> sampled_pressure --> sampled_pressure (C) Pa
        tension (T) N ----------> sampled_tension ---> sampled_tension (T) N

    of the C chambers and the T tendons that there are. With errors, the sensor's error-free readings, its
    `extension_ratio` and the sampled true pressure are the outputs `ideal_strain`, `ideal_extension_ratio` and
    `ideal_pressure`; each block of errors takes random numbers::

        sensor ------------> ideal_strain ----> reading_errors ---> strain
        reading_errors.random -----------------------^
        sampled_pressure --> ideal_pressure --> pressure_errors --> sampled_pressure
        pressure_errors.random ----------------------^
    """

    def __init__(self, sensor: System, layout: MeasurementModel, config: SensorConfig):
        """
        Args:
            sensor: see `sensor_presets`.
            layout: layout of its readings.
            config: the `sensor` part, whose sampling period and errors are used.

        Raises:
            InputError: if an error is invalid.
        """
        super().__init__()
        wires = NamedWires()
        period = config.period
        finger = layout.finger
        errors = strain_errors(config, finger.name)
        ideals = {name: f"{IDEAL}{name}" for name in (layout.quantity, "extension_ratio")}
        wires.add("sensor", sensor, {} if errors is None else ideals)
        sampled = "sampled_pressure" if config.pressure_errors is None else f"{IDEAL}pressure"
        if count := finger.pressures:
            wires.add(
                "sampled_pressure",
                Hold(period, count, 0, "Pa", **finger.chamber_axis),
                {"u": "pressure", "y": sampled},
            )
        if finger.tendons:
            hold = Hold(period, len(finger.tendons), 0, "N", **finger.tendon_axis)
            wires.add("sampled_tension", hold, {"u": "tension", "y": "sampled_tension"})
        if errors is not None:
            wires.add("reading_errors", ReadingErrorBlock(layout, errors, period), _random_input("reading_errors"))
        if config.pressure_errors is not None and count:
            ideal = f"{IDEAL}pressure"
            disturbed = "sampled_pressure"
            block = ErrorBlock(
                config.pressure_errors, count, period, ideal, disturbed, unit="Pa", **finger.chamber_axis
            )
            wires.add("pressure_errors", block, _random_input("pressure_errors"))
        wires.build_into(self)


def _random_input(name: str) -> dict[str, str]:
    """Names the random input of a block of errors after the block."""
    return {"standard_normal": f"{name}{RANDOM}"}


def _add_random(builder: DiagramBuilder, finger: str, sensors: PartPorts, period: float) -> Ports:
    """Adds a `{finger}.{input}` for each random input of the sensors of a finger; returns them by input."""
    random_ports = {}
    for name, port in sensors.inputs.items():
        if name.endswith(RANDOM):
            source = RandomSource(RandomDistribution.kGaussian, port.size(), period)
            random_ports[name] = builder.AddNamedSystem(f"{finger}.{name}", source).get_output_port()
    return random_ports


def add_joint_angles(builder: DiagramBuilder, finger: PlantFinger, deformation: str = "bending") -> OutputPort:
    """Adds `{finger}.joint_angles`, or the port of another deformation; returns it, (N) rad, or m if joints slide."""
    selector = MatrixGain(finger.position_selector(deformation))
    state = finger.plant.get_state_output_port()
    angles = add_stage(builder, f"{finger.name}.{joints_port(deformation)}", selector, state)
    return describe(angles, "m" if deformation in SLIDES else "rad", joint=range(finger.finger.segments))


def add_base_pose(builder: DiagramBuilder, finger: PlantFinger, period: float) -> OutputPort:
    """Adds `{finger}.base_pose`: X_WB (12) [R | p], constant if the base is fixed, otherwise sampled."""
    name = f"{finger.name}.base_pose"
    if finger.is_anchored:
        return builder.AddNamedSystem(name, FixedBasePose(finger.X_WB)).get_output_port()
    sensor = BasePoseSensor(finger.base.index(), period)
    return add_stage(builder, name, sensor, finger.plant.get_body_poses_output_port())


def add_sensors(
    builder: DiagramBuilder,
    finger: PlantFinger,
    config: SensorConfig,
    pressure: OutputPort | None,
    make_sensor: MakeSensor | None = None,
    tension: OutputPort | None = None,
) -> Ports:
    """Adds `{finger}.sensors`, with `{finger}.joint_angles` and `{finger}.base_pose` before it.

    Args:
        builder: of a diagram with the finger's plant.
        finger: a finger in the finalized plant.
        config: the `sensor` part of a scenario.
        pressure: pressures in the chambers of the finger, (C) Pa; None: it has none.
        make_sensor: replaces the sensor named by `config.type`, see `sensor_presets`.
        tension: of the tendons of the finger, (T) N; None: it has none.

    Returns:
        the signals, by name without the finger's prefix.

    Raises:
        InputError: if the sensor requires an unknown signal, or has no readings.
    """
    part = add_part(builder, f"{finger.name}.sensors", make_sensors(finger.finger, config, make_sensor))
    return connect_sensors(builder, finger, part, config, pressure, tension, name_of(make_sensor, config.type))


def make_sensors(finger: Finger, config: SensorConfig, make_sensor: MakeSensor | None = None) -> FingerSensors:
    """The sensors of a finger, in no diagram yet; arguments and errors as for `add_sensors`."""
    kind = make_sensor or SENSORS.find(config.type)
    layout = sensor_layout(finger, config)
    made_by = ("sensor.type", name_of(make_sensor, config.type))
    if is_measurement_model(make_sensor):
        raise InputError("make_sensor", "class", made_by[1], "is a kind of sensor: name it as `sensor.type` instead")
    make = kind if not is_measurement_model(kind) else StrainSensor if measures_strain(layout) else SensorBlock
    sensor = make_block(*made_by, make, layout, config.period)
    with blamed_on(*made_by):
        _check(sensor, layout, config)
        return FingerSensors(sensor, layout, config)


def connect_sensors(
    builder: DiagramBuilder,
    finger: PlantFinger,
    part: PartPorts,
    config: SensorConfig,
    pressure: OutputPort | None,
    tension: OutputPort | None,
    made_by: str,
) -> Ports:
    """Connects the sensors of `make_sensors` to the signals that they measure; `made_by` names the sensor."""
    layout = sensor_layout(finger.finger, config)
    X_WB = add_base_pose(builder, finger, config.period)
    sources = {
        **{joints_port(name): add_joint_angles(builder, finger, name) for name in layout.deformations},
        "pressure": pressure,
        "tension": tension,
        "X_WB": X_WB,
    }
    available = {name: port for name, port in sources.items() if port is not None}
    with blamed_on("sensor.type", made_by):
        random = _add_random(builder, finger.name, part, config.period)
        connect_by_name(builder, part.inputs, available | random, "sensor")
        if layout.quantity not in part.outputs:
            expected = f"a sensor outputs its readings as '{layout.quantity}'"
            raise InputError("sensor", "output ports", ", ".join(part.outputs), expected)
    return {"joint_angles": available["joint_angles"], "X_WB": X_WB, **part.outputs}


def _check(sensor: System, layout: MeasurementModel, config: SensorConfig) -> None:
    """Checks the outputs of a sensor: its readings, and no name of another signal of the finger."""
    sizes = {name: port.size() for name, port in vector_outputs(sensor).items()}
    reserved = ("joint_angles", "pressure", "sampled_pressure", "tension", "sampled_tension", "X_WB")
    reserved_names = sorted(name for name in sizes if name in reserved or name.startswith(IDEAL))
    if reserved_names:
        names = ", ".join(reserved_names)
        raise InputError("sensor", "output ports", names, "are names of other signals of the finger")
    errors = strain_errors(config, layout.finger.name)
    if errors is None:
        return
    if sizes.get(layout.quantity) != layout.readings:
        expected = f"output '{layout.quantity}' ({layout.readings}), the readings to which sensor.errors apply"
        raise InputError("sensor", "output ports", sizes, expected)
    if any(reading >= layout.readings for reading in errors.dead):
        raise InputError("sensor.errors", "dead", list(errors.dead), f"there are {layout.readings} readings")
