"""Scoring, applied: compares estimates with ground truth from the simulation. Nothing else depends on it."""

from collections.abc import Mapping, Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.estimation import estimation_inputs, shape_wires
from soft_gripper.diagrams.wiring.named_wires import (
    NamedWires,
    Ports,
    add_stage,
    connect_by_name,
    inputs,
    vector_outputs,
)
from soft_gripper.estimators.driving_torque import driving_port
from soft_gripper.estimators.finger_shape import TIP
from soft_gripper.estimators.named_estimators import find_estimator
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.load.force_estimator import DELAY
from soft_gripper.registry import blamed_on, label, make_block
from soft_gripper.scenario.deformables import deformable_body
from soft_gripper.scenario.schema import EstimatorConfig, SensorConfig
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_block import Hold
from soft_gripper.truth.contact import TouchedLinks, TrueContact
from soft_gripper.truth.poses import TRUE_JOINTS, Difference, PoseError, TruePoses, rotations_out_of_plane

_DELAYED_TORQUE = "delayed_torque"  # not a signal: the true torque at the sample to which the estimate belongs


class FingerScoring(Diagram):
    """Ground truth for one finger, sampled with the sensors, and the errors of the estimates.

    ::

        true_joint_positions, true_tip_position --> PoseError ----------> pose_error, fingertip_error  (1) m
        joint_positions, tip_pose ---------------------^
        joint_angles (N) rad ----> sampled_joint_angles
        contact_torque (N) N m --> true_external_torque
                     +-----------> delayed_torque --> Difference -------> external_torque_error  (N) N m
        external_torque (N) N m ------------------------^

    A finger that turns out of its plane also has true_sideways_torque and true_twist_torque, from
    sideways_contact_torque and twist_contact_torque: contact torques about the axes of these joints.

    The true torque is delayed, because the estimated one belongs to earlier samples, see `ForceEstimator`.
    """

    def __init__(self, finger: Finger, period: float, is_in_space: bool = False):
        """`finger` is the simulated finger; `period` of samples, s; `is_in_space`: whether it is estimated there."""
        super().__init__()
        joints = finger.segments
        wires = NamedWires()
        sampled = [("sampled_joint_angles", "joint_angles", "rad"), ("true_external_torque", "contact_torque", "N m")]
        sampled += [(f"true_{name}_torque", f"{name}_contact_torque", "N m") for name in rotations_out_of_plane(finger)]
        for name, source, unit in sampled:
            hold = Hold(period, joints, unit=unit, joint=range(joints))
            wires.add(name, hold, {"u": source, "y": name})
        wires.add("pose_error", PoseError(joints, is_in_space))
        delay = Hold(period, joints, DELAY, unit="N m", joint=range(joints))
        wires.add("delay", delay, {"u": "contact_torque", "y": _DELAYED_TORQUE})
        names = {"estimate": "external_torque", "truth": _DELAYED_TORQUE, "difference": "external_torque_error"}
        wires.add("torque_error", Difference(joints, "N m", joint=range(joints)), names)
        wires.build_into(self)


def add_scoring(builder: DiagramBuilder, finger: PlantFinger, period: float, known: Mapping[str, OutputPort]) -> Ports:
    """Adds `{finger}.scoring`, with `{finger}.contact_torque` and the like before it.

    Args:
        builder: of a diagram with the finger's plant.
        finger: a finger in the finalized plant.
        period: sampling period, s.
        known: the signals returned by `add_sensors` and `add_estimation`, and the finger's signals of `add_true_poses`.

    Returns:
        the signals, by name without the finger's prefix.
    """
    forces = finger.plant.get_generalized_contact_forces_output_port(finger.model)
    sources = dict(known)
    for deformation in ("bending", *rotations_out_of_plane(finger.finger)):
        name = "contact_torque" if deformation == "bending" else f"{deformation}_contact_torque"
        selector = MatrixGain(finger.torque_selector(deformation))
        sources[name] = add_stage(builder, f"{finger.name}.{name}", selector, forces)
    scoring = builder.AddNamedSystem(f"{finger.name}.scoring", FingerScoring(finger.finger, period, TIP in known))
    for name, port in inputs(scoring).items():
        builder.Connect(sources[name], port)
    signals = vector_outputs(scoring)
    del signals[_DELAYED_TORQUE]
    return signals


def add_true_poses(builder: DiagramBuilder, fingers: Sequence[PlantFinger], period: float) -> Ports:
    """Adds `true_poses` for fingers of one plant, sampled every `period` s; returns the signals `{finger}.{signal}`."""
    plant = fingers[0].plant
    name = _free_name(builder, "true_poses", fingers)
    size = plant.num_multibody_states()
    hold = Hold(period, size, state=range(size))
    sampled = add_stage(builder, f"{name}.state", hold, plant.get_state_output_port())
    truth = builder.AddNamedSystem(name, TruePoses(fingers))
    builder.Connect(sampled, truth.get_input_port())
    return vector_outputs(truth)


def _free_name(builder: DiagramBuilder, name: str, fingers: Sequence[PlantFinger]) -> str:
    """The name, with the first finger's name as prefix if fingers already have a block of that name."""
    return f"{fingers[0].name}.{name}" if builder.HasSubsystemNamed(name) else name


def add_true_contact(builder: DiagramBuilder, fingers: Sequence[PlantFinger], interval: float | None = None) -> Ports:
    """Adds `true_contact` for fingers of one plant, which is NaN but every `interval` s; None: known at all times.

    Returns:
        its signals, `{finger}.{signal}`, `{object}.{signal}` of every free model, and `width`.
    """
    plant = fingers[0].plant
    name = _free_name(builder, "true_contact", fingers)
    links = {finger.name: TouchedLinks.from_finger(finger) for finger in fingers}
    truth = builder.AddNamedSystem(name, TrueContact(links, interval, _objects(plant, fingers)))
    builder.Connect(plant.get_contact_results_output_port(), truth.GetInputPort("contact_results"))
    builder.Connect(plant.get_body_poses_output_port(), truth.GetInputPort("body_poses"))
    return vector_outputs(truth)


def _objects(plant: MultibodyPlant, fingers: Sequence[PlantFinger]) -> dict[str, list[int]]:
    """The collision geometries of every free model without fingers, by its name; values of their GeometryIds."""
    free_models = {plant.get_body(index).model_instance() for index in plant.GetFloatingBaseBodies()}
    geometry_ids: dict[str, list[int]] = {}
    for model in sorted(free_models - {finger.model for finger in fingers}):
        bodies = map(plant.get_body, plant.GetBodyIndices(model))
        geometries = [geometry for body in bodies for geometry in plant.GetCollisionGeometriesForBody(body)]
        geometry_ids[str(plant.GetModelInstanceName(model))] = [geometry.get_value() for geometry in geometries]
    for model in map(ModelInstanceIndex, range(plant.num_model_instances())):
        if deformable := deformable_body(plant, model):
            geometry_ids[str(plant.GetModelInstanceName(model))] = [deformable.geometry_id().get_value()]
    return geometry_ids


def add_width_error(builder: DiagramBuilder, width: OutputPort, truth: OutputPort) -> OutputPort:
    """Adds `object_width_error`, estimated minus true width; returns it, (1) m."""
    error = builder.AddNamedSystem("object_width_error", Difference(1, "m"))
    builder.Connect(width, error.GetInputPort("estimate"))
    builder.Connect(truth, error.GetInputPort("truth"))
    return error.get_output_port()


class AlongsideEstimation(Diagram):
    """A further estimate of the shape of a finger.

    ::

        strain --------------------------> estimator ---> estimated_joint_angles ---> FingerShape ---> pose
        X_WB (12) [R | p] -------------------^ ^
        pressure (1) Pa --> DrivingTorque -----+

    As in FingerEstimation; the creep state is computed from this estimator's shapes.
    """

    def __init__(self, estimator: System, finger: Finger, period: float):
        """
        Raises:
            InputError: if the estimator does not estimate the joint angles of the finger.
        """
        super().__init__()
        wires = shape_wires(estimator, finger, period)
        for name in ("bending", *finger.driven_deformations):  # names of the estimate that the run uses
            wires.outputs.pop(driving_port(name), None)
        wires.build_into(self)


def add_alongside(
    builder: DiagramBuilder,
    finger: PlantFinger,
    layout: MeasurementModel,
    config: EstimatorConfig,
    sensor: SensorConfig,
    measured: Mapping[str, OutputPort],
) -> Ports:
    """Adds `{finger}.{type}.estimation` and `{finger}.{type}.scoring` for every type in `config.alongside`.

    Arguments and signals as for `add_estimation`; `measured` has the finger's signals of `add_true_poses`, too.

    Raises:
        InputError: if there is no such estimator.
    """
    gravity: Array = np.array(finger.plant.gravity_field().gravity_vector()) * config.compensate_gravity
    signals: Ports = {}
    period = sensor.period
    for kind in config.alongside:
        make = find_estimator(kind, uncertainty(config, sensor, layout.calibrated), "estimator.alongside")
        estimator = make_block("estimator.alongside", kind, make, layout, gravity, period)
        with blamed_on("estimator.alongside", kind):
            estimation = AlongsideEstimation(estimator, layout.finger, period)
            builder.AddNamedSystem(f"{finger.name}.{label(kind)}.estimation", estimation)
            connect_by_name(builder, inputs(estimation), estimation_inputs(measured), "estimator")
        estimates = vector_outputs(estimation)
        if TRUE_JOINTS in measured:
            errors = PoseError(finger.finger.segments, TIP in estimates)
            scoring = builder.AddNamedSystem(f"{finger.name}.{label(kind)}.scoring", errors)
            connect_by_name(builder, inputs(scoring), {**measured, **estimates}, "score")
            estimates |= vector_outputs(scoring)
        signals |= {f"{label(kind)}.{name}": port for name, port in estimates.items()}
    return signals
