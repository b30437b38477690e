"""make_station: a scenario -> the whole diagram. It reads as a table of contents."""

from dataclasses import dataclass

from pydrake.geometry import Meshcat
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder

from soft_gripper.diagrams.contact_sensing import add_contact_sensing
from soft_gripper.diagrams.drive import add_drive
from soft_gripper.diagrams.grip_control import add_set_points
from soft_gripper.diagrams.manipulation.arm_control import add_arm_at_home
from soft_gripper.diagrams.manipulation.task import add_task
from soft_gripper.diagrams.manipulation.way_check import check_ways
from soft_gripper.diagrams.overlap_check import check_starts_apart
from soft_gripper.diagrams.plant import PlantFinger, add_plant
from soft_gripper.diagrams.pressure_steps import add_pressure_steps
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.diagrams.sensing import add_joint_angles, add_sensing, plant_signals
from soft_gripper.diagrams.signal_logs import SignalLogs
from soft_gripper.diagrams.view.meshcat_view import add_meshcat_view
from soft_gripper.task_machine import TaskMachine


@dataclass(frozen=True)
class Station:
    """A diagram whose output ports are the named signals, `{finger}.{signal}`, each with a log."""

    diagram: Diagram
    plant: MultibodyPlant
    fingers: tuple[PlantFinger, ...]
    logs: SignalLogs
    scenario: Scenario
    task: TaskMachine | None  # what leads through the task, if there is one


def make_station(scenario: Scenario, meshcat: Meshcat | None = None) -> Station:
    """Builds the diagram of a scenario.

        pressure_steps -> {model}.pressure_drive -> plant -> {finger}: FingerSensing -> logs
        or grip_control ----^                         ^                     |
               ^------------------------------------- | --------------------+
               +-- task, or steps of the set point    |
                     +---> {arm}: desired state ------+
        FingerSensing -> {finger}.contact_detector, object_width; plant -> true_contact: all to the logs

    Raises:
        InputError: if a part of the scenario cannot be built.
    """
    builder = DiagramBuilder()
    plant, scene_graph, fingers = add_plant(builder, scenario)
    angles = {finger.name: add_joint_angles(builder, plant, finger) for finger in fingers}
    commands, signals = add_drive(builder, scenario, plant, fingers, angles)
    for finger in fingers:
        pressure = signals[f"{finger.name}.pressure"]
        signals |= add_sensing(builder, scenario, plant, finger, angles[finger.name], pressure)
    if scenario.sensor.contact_threshold > 0:
        signals |= add_contact_sensing(builder, scenario, plant, scene_graph, fingers, signals)
    if scenario.task.phases:
        signals |= add_task(builder, scenario, plant, fingers, commands, signals)
    elif scenario.control.set_points:
        signals |= add_set_points(builder, scenario, fingers, commands, signals)
    else:
        signals |= add_pressure_steps(builder, scenario, commands)
    if scenario.arm.model and not scenario.task.phases:
        add_arm_at_home(builder, scenario, plant, fingers)
    signals |= plant_signals(plant, scenario)
    if meshcat is not None:
        add_meshcat_view(builder, scenario, plant, scene_graph, fingers, signals, meshcat)
    logs = builder.AddNamedSystem("logs", SignalLogs(signals, scenario.sensor.period))
    for name, port in signals.items():
        builder.Connect(port, logs.GetInputPort(name))
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("station")
    check_starts_apart(diagram, scene_graph)
    task = diagram.GetSubsystemByName("task") if scenario.task.phases else None
    if task is not None:
        check_ways(diagram, plant, scene_graph, scenario, fingers, task.phases)
    return Station(diagram, plant, tuple(fingers), logs, scenario, task)
