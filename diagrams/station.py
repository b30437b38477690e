"""make_station: a scenario -> the whole diagram. It reads as a table of contents."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import MatrixGain
from soft_gripper.diagrams.finger_sensing import FingerSensing
from soft_gripper.diagrams.plant import PlantFinger, add_plant, position_selector, torque_selector
from soft_gripper.diagrams.pressure_steps import pressure_source
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.diagrams.signal_logs import SignalLogs

from soft_gripper.pressure_drive import PressureDrive, pressure_torque_map
from soft_gripper.response_curve import LINEAR, ResponseCurve
from soft_gripper.sensor_layout import SensorLayout


@dataclass(frozen=True)
class Station:
    """A diagram whose output ports are the named signals, `{finger}.{signal}`, each with a log."""

    diagram: Diagram
    plant: MultibodyPlant
    fingers: tuple[PlantFinger, ...]
    logs: SignalLogs
    scenario: Scenario


def make_station(scenario: Scenario, meshcat: Meshcat | None = None) -> Station:
    """Builds the diagram of a scenario.

        pressure_steps -> {model}.pressure_drive -> plant -> {finger}: FingerSensing -> logs

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    builder = DiagramBuilder()
    plant, scene_graph, fingers = add_plant(builder, scenario)
    signals = _drive(builder, scenario, plant, fingers)
    for finger in fingers:
        signals |= _sense(builder, scenario, plant, finger, signals[f"{finger.name}.pressure"])
    signals |= _observe(plant, scenario)
    if meshcat is not None:
        MeshcatVisualizer.AddToBuilder(
            builder, scene_graph, meshcat, MeshcatVisualizerParams(publish_period=1 / 20)
        )
    logs = builder.AddNamedSystem("logs", SignalLogs(signals, scenario.sensor.period))
    for name, port in signals.items():
        builder.Connect(port, logs.GetInputPort(name))
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("station")
    return Station(diagram, plant, tuple(fingers), logs, scenario)


def sensor_layout(scenario: Scenario, finger: PlantFinger) -> SensorLayout:
    """The sensors that the scenario puts on a finger."""
    sensor = scenario.sensor
    response = ResponseCurve(tuple(map(tuple, sensor.response)) or LINEAR)
    return SensorLayout(finger.finger, sensor.sections, sensor.one_sided, response)


def _drive(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, fingers: list[PlantFinger]
) -> dict[str, OutputPort]:
    """Pressures on the joints of every model that has fingers; returns the signals."""
    signals = {}
    limits = scenario.pressure
    for model in {finger.model: None for finger in fingers}:
        driven = [finger for finger in fingers if finger.model == model]
        torque_maps = {f.name: pressure_torque_map(plant, model, f.finger) for f in driven}
        drive = PressureDrive(torque_maps, limits.minimum, limits.maximum, limits.time_constant)
        builder.AddNamedSystem(f"{plant.GetModelInstanceName(model)}.pressure_drive", drive)
        builder.Connect(drive.GetOutputPort("actuation"), plant.get_actuation_input_port(model))
        for name in torque_maps:
            source = pressure_source(scenario, name)
            builder.AddNamedSystem(f"{name}.pressure_steps", source)
            builder.Connect(source.get_output_port(), drive.GetInputPort(f"{name}.pressure_command"))
            signals[f"{name}.pressure_command"] = source.get_output_port()
            signals[f"{name}.pressure"] = drive.GetOutputPort(f"{name}.pressure")
    return signals


def _sense(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    finger: PlantFinger,
    pressure: OutputPort,
) -> dict[str, OutputPort]:
    """The sensors of a finger and what is estimated from them; returns the signals."""
    gravity = np.array(scenario.gravity) * scenario.sensor.compensate_gravity
    layout = sensor_layout(scenario, finger)
    sensing = FingerSensing(layout, scenario.sensor.period, finger.X_WB, gravity)
    builder.AddNamedSystem(finger.name, sensing)
    angles, torques = MatrixGain(position_selector(plant, finger)), MatrixGain(torque_selector(plant, finger))
    for name, port, selector in (
        ("joint_angles", plant.get_state_output_port(), angles),
        ("contact_torque", plant.get_generalized_contact_forces_output_port(finger.model), torques),
    ):
        builder.AddNamedSystem(f"{finger.name}.{name}", selector)
        builder.Connect(port, selector.get_input_port())
        builder.Connect(selector.get_output_port(), sensing.GetInputPort(name))
    builder.Connect(pressure, sensing.GetInputPort("pressure"))
    ports = [sensing.get_output_port(i) for i in range(sensing.num_output_ports())]
    return {f"{finger.name}.{port.get_name()}": port for port in ports}


def _observe(plant: MultibodyPlant, scenario: Scenario) -> dict[str, OutputPort]:
    """Signals that come straight from the plant."""
    signals = {"plant.state": plant.get_state_output_port()}
    for model in scenario.models:
        if model.free:
            instance = plant.GetModelInstanceByName(model.name)
            port = plant.get_generalized_contact_forces_output_port(instance)
            signals[f"{model.name}.contact_force"] = port
    return signals
