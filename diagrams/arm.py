"""The arm: a separate plant for planning and gravity compensation.

Planning and gravity compensation use a plant of the arm alone (`Arm.plant`), in which the gripper is one rigid body.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.schema import Transform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, ModelInstanceIndex, PdControllerGains, SpatialInertia
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import ConstantVectorSource, MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.control.arm_motion import GravityCompensation
from soft_gripper.control.couplings import Couplings, couplings
from soft_gripper.diagrams.scene import add_model, arm_joints, find_frame, own_frame
from soft_gripper.diagrams.wiring.named_wires import add_stage
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import ArmConfig, ModelConfig


@dataclass(frozen=True)
class Arm:
    """An arm that carries a gripper."""

    name: str
    model: ModelInstanceIndex  # in the plant of the station
    plant: MultibodyPlant  # of the arm alone, with its whole payload as one rigid body
    tool: Frame  # in this plant: the frame at which the gripper is welded
    tool_model: ModelConfig  # the model welded at that frame
    config: ArmConfig
    couplings: Couplings  # of its joints

    @property
    def home(self) -> Array:
        """The initial posture, (n) rad or m."""
        return self.couplings.full(np.array(self.config.home))


def make_arm(
    plant: MultibodyPlant, models: Sequence[ModelConfig], arm: ArmConfig, fingers: Sequence[PlantFinger] = ()
) -> Arm:
    """The arm among the models of the finalized `plant`.

    Raises:
        InputError: if it does not carry the fingers.
    """
    index = [model.name for model in models].index(arm.model)
    config = models[index]
    gripper = gripper_model(models, arm.model, fingers)
    arm_plant = MultibodyPlant(0.0)
    arm_plant.mutable_gravity_field().set_gravity_vector(plant.gravity_field().gravity_vector())
    X_WBase = own_frame(plant, config, f"models[{index}]").CalcPoseInWorld(plant.CreateDefaultContext())
    arm_model = replace(config, parent="world", X_PC=Transform(X_WBase))
    _, _, mimics = add_model(arm_plant, arm_model, f"models[{index}]", arm)
    inertia = _inertia(plant, gripper, carried_models(models, arm.model))
    body = arm_plant.AddRigidBody("payload", arm_plant.AddModelInstance("carried"), inertia)
    parent = find_frame(arm_plant, gripper.parent, "models", "parent")
    arm_plant.WeldFrames(parent, body.body_frame(), gripper.X_PC.GetDeterministicValue())
    arm_plant.Finalize()
    model = plant.GetModelInstanceByName(config.name)
    joints = [joint.name() for joint in arm_joints(plant, model)]
    return Arm(config.name, model, arm_plant, body.body_frame(), gripper, arm, couplings(joints, mimics))


def carried_models(models: Sequence[ModelConfig], arm: str) -> list[ModelConfig]:
    """The models that the arm carries, excluding the arm itself."""
    names = [arm]
    for model in models:
        if model.parent.rpartition("::")[0] in names and not model.free:
            names.append(model.name)
    return [model for model in models if model.name in names[1:]]


def gripper_model(models: Sequence[ModelConfig], arm: str, fingers: Sequence[PlantFinger]) -> ModelConfig:
    """The model welded to the arm that contains or carries the fingers; without fingers, the first one carried.

    Raises:
        InputError: if the fingers are not attached to the arm, or are attached through several models.
    """
    models_by_name = {model.name: model for model in models}
    tips = {finger.model_name for finger in fingers} or {model.name for model in carried_models(models, arm)[:1]}
    welded = set()
    for name in tips:
        while name in models_by_name and models_by_name[name].parent.rpartition("::")[0] != arm:
            name = models_by_name[name].parent.rpartition("::")[0]
        welded.add(name)
    if len(welded) != 1 or not welded <= set(models_by_name):
        raise InputError("arm", "model", arm, f"does not carry the gripper; weld the gripper to it: parent: {arm}::...")
    return models_by_name[welded.pop()]


def _inertia(plant: MultibodyPlant, gripper: ModelConfig, payload: Sequence[ModelConfig]) -> SpatialInertia:
    """Inertia of the whole payload as one body, about and expressed in the frame at which the gripper is welded."""
    bodies = [index for model in payload for index in plant.GetBodyIndices(plant.GetModelInstanceByName(model.name))]
    return plant.CalcSpatialInertia(plant.CreateDefaultContext(), own_frame(plant, gripper, "models"), bodies)


def add_home(builder: DiagramBuilder, arm: Arm, desired: InputPort) -> OutputPort:
    """Adds `{arm}.home`, which holds the arm in its home posture; returns its desired state."""
    home = ConstantVectorSource([*arm.home, *np.zeros_like(arm.home)])
    builder.AddNamedSystem(f"{arm.name}.home", home)
    builder.Connect(home.get_output_port(), desired)
    return home.get_output_port()


def add_arm_control(builder: DiagramBuilder, plant: MultibodyPlant, arm: Arm) -> InputPort:
    """Adds `{arm}.gravity_compensation` and gives every actuator of the arm a PD controller.

    ::

        desired state ----------------------------> PD controllers, solved with the plant's own equations
        state of the arm -> GravityCompensation -> actuators, within their effort limits

    The compensation includes the weight of the gripper, but not that of a grasped object. Joints that follow others
    have no actuator: those that they follow carry their weight.

    Returns:
        the input port of the desired state, positions and then velocities in the order of the joints, (2 n).
    """
    _set_gains(plant, arm)
    compensation = GravityCompensation(arm.plant)
    state = plant.get_state_output_port(arm.model)
    weight = add_stage(builder, f"{arm.name}.gravity_compensation", compensation, state)
    actuator_rows = _actuator_rows(plant, arm)
    leader_map = np.eye(len(arm.couplings.offset))[arm.couplings.leads]
    torque = add_stage(builder, f"{arm.name}.torque", MatrixGain(actuator_rows @ arm.couplings.matrix.T), weight)
    builder.Connect(torque, plant.get_actuation_input_port(arm.model))
    # Drake's cenic (1.51 and 1.58) applies a desired velocity with the wrong sign: it is 0, and the desired position is
    # the one that gives the same PD torque.
    position_map = [[1.0, arm.config.damping_ratio / (np.pi * arm.config.frequency)], [0.0, 0.0]]
    gain = MatrixGain(np.kron(position_map, actuator_rows @ leader_map))
    desired = builder.AddNamedSystem(f"{arm.name}.desired", gain)
    builder.Connect(desired.get_output_port(), plant.get_desired_state_input_port(arm.model))
    return desired.get_input_port()


def _leading(plant: MultibodyPlant, arm: Arm) -> list[Joint]:
    """The joints of an arm that follow no other."""
    joints = arm_joints(plant, arm.model)
    return [joints[i] for i in arm.couplings.leads]


def _set_gains(plant: MultibodyPlant, arm: Arm) -> None:
    """Gains of a joint for the desired frequency, from the inertia that it moves in the home posture."""
    context = arm.plant.CreateDefaultContext()
    arm.plant.SetPositions(context, arm.home)
    follow = arm.couplings.matrix
    inertia = np.diag(follow.T @ arm.plant.CalcMassMatrix(context) @ follow)
    angular_frequency = 2 * np.pi * arm.config.frequency  # rad/s
    ratio = arm.config.damping_ratio
    gains = {
        joint.name(): PdControllerGains(p=moment * angular_frequency**2, d=2 * ratio * moment * angular_frequency)
        for joint, moment in zip(_leading(plant, arm), inertia, strict=True)
    }
    for index in plant.GetJointActuatorIndices(arm.model):
        actuator = plant.get_joint_actuator(index)
        actuator.set_controller_gains(gains[actuator.joint().name()])


def _actuator_rows(plant: MultibodyPlant, arm: Arm) -> Array:
    """Matrix that maps the order of the leading joints to the order of the actuators, (k, k)."""
    names = [joint.name() for joint in _leading(plant, arm)]
    actuators = (plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices(arm.model))
    return np.eye(len(names))[[names.index(actuator.joint().name()) for actuator in actuators]]
