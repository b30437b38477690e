"""The drive: pressures, and elastic laws of the user's, as torques on the joints of the fingers."""

from collections.abc import Mapping

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import Adder, MatrixGain

from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.elastic_law import ElasticLawTorque
from soft_gripper.pressure_drive import PressureDrive, actuator_rows, pressure_torque_map

Ports = dict[str, OutputPort]


def add_drive(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    fingers: list[PlantFinger],
    joint_angles: Mapping[str, OutputPort],
) -> tuple[dict[str, InputPort], Ports]:
    """Adds `{model}.pressure_drive` for every model with fingers.

    Returns:
        where the command of every finger goes in, and the signal of the pressure in every finger.
    """
    commands: dict[str, InputPort] = {}
    signals: Ports = {}
    for model in dict.fromkeys(finger.model for finger in fingers):
        driven = [finger for finger in fingers if finger.model == model]
        drive = _add_pressure_drive(builder, scenario, plant, driven)
        for name in (finger.name for finger in driven):
            commands[name] = drive.GetInputPort(f"{name}.pressure_command")
            signals[f"{name}.pressure"] = drive.GetOutputPort(f"{name}.pressure")
        elastic = [_add_elastic_law(builder, plant, f, joint_angles[f.name]) for f in driven if f.finger.elastic_law]
        _actuate(builder, plant, model, [drive.GetOutputPort("actuation"), *elastic])
    return commands, signals


def _add_pressure_drive(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, driven: list[PlantFinger]
) -> PressureDrive:
    model, supply = driven[0].model, scenario.pressure
    torque_maps = {f.name: pressure_torque_map(plant, model, f.finger) for f in driven}
    drive = PressureDrive(
        torque_maps, supply.minimum, supply.maximum, supply.time_constant, scenario.plant_config.time_step
    )
    return builder.AddNamedSystem(f"{plant.GetModelInstanceName(model)}.pressure_drive", drive)


def _add_elastic_law(
    builder: DiagramBuilder, plant: MultibodyPlant, finger: PlantFinger, joint_angles: OutputPort
) -> OutputPort:
    """What the finger's elastic law adds to its linear springs, as actuation of its model."""
    law = builder.AddNamedSystem(f"{finger.name}.elastic_law", ElasticLawTorque(finger.finger))
    rows = actuator_rows(plant, finger.model, finger.finger)
    spread = builder.AddNamedSystem(f"{finger.name}.elastic_torque", MatrixGain(np.ascontiguousarray(rows.T)))
    builder.Connect(joint_angles, law.get_input_port())
    builder.Connect(law.get_output_port(), spread.get_input_port())
    return spread.get_output_port()


def _actuate(
    builder: DiagramBuilder, plant: MultibodyPlant, model: ModelInstanceIndex, torques: list[OutputPort]
) -> None:
    """Connects the sum of torques to the actuators of a model."""
    actuation = plant.get_actuation_input_port(model)
    if len(torques) == 1:
        builder.Connect(torques[0], actuation)
        return
    total = Adder(len(torques), actuation.size())
    builder.AddNamedSystem(f"{plant.GetModelInstanceName(model)}.actuation", total)
    for i, torque in enumerate(torques):
        builder.Connect(torque, total.get_input_port(i))
    builder.Connect(total.get_output_port(), actuation)
