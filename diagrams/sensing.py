"""The sensing: what is read and estimated of every finger, and what the plant itself tells."""

import numpy as np
from pydrake.common.value import Value
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import ConstantValueSource, MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.base_pose_sensor import BasePoseSensor
from soft_gripper.diagrams.finger_sensing import FingerSensing
from soft_gripper.diagrams.plant import PlantFinger, position_selector, torque_selector
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.response_curve import LINEAR, ResponseCurve
from soft_gripper.sensor_layout import SensorLayout


def sensor_layout(scenario: Scenario, finger: PlantFinger) -> SensorLayout:
    """The sensors that the scenario puts on a finger."""
    sensor = scenario.sensor
    response = ResponseCurve(tuple(map(tuple, sensor.response)) or LINEAR)
    return SensorLayout(finger.finger, sensor.sections, sensor.one_sided, response)


def compensated_gravity(scenario: Scenario) -> Array:
    """Gravity that the force estimate is compensated for, in the world, (3,) m/s^2."""
    return np.array(scenario.gravity) * scenario.sensor.compensate_gravity


def bending_plane_gravity(scenario: Scenario, finger: PlantFinger) -> complex:
    """The same in the bending plane of a finger, z + i x in B, m/s^2."""
    x, _, z = finger.X_WB.rotation().matrix().T @ compensated_gravity(scenario)
    return complex(z, x)


def add_joint_angles(builder: DiagramBuilder, plant: MultibodyPlant, finger: PlantFinger) -> OutputPort:
    """Adds `{finger}.joint_angles`; returns the joint angles of a finger, (N) rad."""
    selector = MatrixGain(position_selector(plant, finger))
    builder.AddNamedSystem(f"{finger.name}.joint_angles", selector)
    builder.Connect(plant.get_state_output_port(), selector.get_input_port())
    return selector.get_output_port()


def add_sensing(
    builder: DiagramBuilder,
    scenario: Scenario,
    plant: MultibodyPlant,
    finger: PlantFinger,
    joint_angles: OutputPort,
    pressure: OutputPort,
) -> dict[str, OutputPort]:
    """Adds the FingerSensing of a finger, named like it; returns the signals."""
    layout = sensor_layout(scenario, finger)
    sensing = FingerSensing(layout, scenario.sensor.period, compensated_gravity(scenario))
    builder.AddNamedSystem(finger.name, sensing)
    contact = MatrixGain(torque_selector(plant, finger))
    builder.AddNamedSystem(f"{finger.name}.contact_torque", contact)
    builder.Connect(plant.get_generalized_contact_forces_output_port(finger.model), contact.get_input_port())
    builder.Connect(_add_base_pose(builder, scenario, plant, finger), sensing.GetInputPort("X_WB"))
    builder.Connect(joint_angles, sensing.GetInputPort("joint_angles"))
    builder.Connect(pressure, sensing.GetInputPort("pressure"))
    builder.Connect(contact.get_output_port(), sensing.GetInputPort("contact_torque"))
    ports = [sensing.get_output_port(i) for i in range(sensing.num_output_ports())]
    return {f"{finger.name}.{port.get_name()}": port for port in ports}


def _add_base_pose(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, finger: PlantFinger
) -> OutputPort:
    """Adds `{finger}.base_pose`: constant where the base stands still, else sampled."""
    if plant.IsAnchored(plant.get_body(finger.base)):
        return builder.AddNamedSystem(
            f"{finger.name}.base_pose", ConstantValueSource(Value(finger.X_WB))
        ).get_output_port()
    sensor = builder.AddNamedSystem(f"{finger.name}.base_pose", BasePoseSensor(finger.base, scenario.sensor.period))
    builder.Connect(plant.get_body_poses_output_port(), sensor.get_input_port())
    return sensor.get_output_port()


def plant_signals(plant: MultibodyPlant, scenario: Scenario) -> dict[str, OutputPort]:
    """Signals that come straight from the plant: its state, and the contact force on every free object."""
    signals = {"plant.state": plant.get_state_output_port()}
    for model in scenario.models:
        if model.free:
            instance = plant.GetModelInstanceByName(model.name)
            port = plant.get_generalized_contact_forces_output_port(instance)
            signals[f"{model.name}.contact_force"] = port
    return signals
