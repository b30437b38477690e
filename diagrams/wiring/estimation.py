"""The estimation of a finger, applied: readings, pressure and base pose -> shape, load and contact."""

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System

from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.composed import add_parts
from soft_gripper.diagrams.wiring.named_wires import NamedWires, Ports, connect_by_name, inputs, vector_outputs
from soft_gripper.diagrams.wiring.sensors import IDEAL
from soft_gripper.errors import InputError
from soft_gripper.estimators.calibration_range import DISAGREEMENT, DISTANCE, FAR, CalibrationRange
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE, DrivingTorque, driving_port
from soft_gripper.estimators.finger_shape import ANGLES, FingerShape
from soft_gripper.estimators.named_estimators import MakeEstimator, find_estimator
from soft_gripper.estimators.recursive import EFFECTIVE_DRIVING_TORQUE
from soft_gripper.estimators.shape_estimator import zeroed
from soft_gripper.fingers.finger import Finger
from soft_gripper.load.contact_detector import ContactDetector
from soft_gripper.load.force_estimator import ForceEstimator
from soft_gripper.registry import blamed_on, is_own, make_block, name_of, registered
from soft_gripper.scenario.schema import EstimatorConfig, SensorConfig
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP


class FingerEstimation(Diagram):
    """Computes all estimates of one finger from measurements, without ground truth.

    ::

        strain --------------------------> estimator --> estimated_joint_angles --> FingerShape -----> pose
        X_WB (12) [R | p] -------------------^ ^             |    |
        pressure (C) Pa --> DrivingTorque -----+             |    +---------------> ForceEstimator --> external torque
                                ^----- with creep -----------+                           |
                                                            contact, if detected <---- ContactDetector
        strain, X_WB, driving torque --> CalibrationRange --> distance from the states of a calibration, if there is one

    With a monitor, its `usable_strain` takes the place of the readings (`make_monitor`); the distance is that of the
    readings as the estimator uses them, zeroed if it does so.

    FingerShape is present if the estimator does not output the pose itself; if it outputs `external_torque`, that
    replaces the output of the ForceEstimator. The driving torque also goes to the ForceEstimator. With recorded signals
    connected to the inputs, the same blocks estimate shape and load on hardware.
    """

    def __init__(
        self,
        estimator: System,
        layout: MeasurementModel,
        gravity: Array,
        period: float,
        contact_threshold: float | None = None,
        monitor: System | None = None,
    ):
        """
        Args:
            estimator: of the shape, see `named_estimators`.
            layout: the nominal sensors and finger.
            gravity: in the world, (3,) m/s^2; zero leaves the finger's own weight in the external torque.
            period: of all samples, s.
            contact_threshold: N m; None: contact is not looked for.
            monitor: of the readings; the estimator takes those that it judges usable. None: there is none.

        Raises:
            InputError: if the estimator does not estimate the joint angles of the finger.
        """
        super().__init__()
        wires = shape_wires(estimator, layout.finger, period, {} if monitor is None else {layout.quantity: monitor})
        learnt = EFFECTIVE_DRIVING_TORQUE in vector_outputs(estimator)
        force = ForceEstimator(layout.finger, gravity, period, learnt)
        wires.add("force_estimator", force, {DRIVING_TORQUE: EFFECTIVE_DRIVING_TORQUE} if learnt else {})
        if contact_threshold is not None:
            detector = ContactDetector(
                layout.finger.segments, int(layout.joints_per_section[0]), period, contact_threshold
            )
            wires.add("contact_detector", detector)
        else:
            del wires.outputs["torque_tolerance"]  # used by the detector only
        if layout.calibrated is not None:
            names = zeroed(layout.quantity), usable(layout.quantity)
            used = next((name for name in names if name in wires.outputs), layout.quantity)
            states = CalibrationRange(layout, layout.calibrated, gravity)
            wires.add("calibration_range", states, {layout.quantity: used})
        wires.build_into(self)


_RESERVED_OUTPUTS = {
    *(DRIVING_TORQUE, "free_bending_angles", "torque_tolerance"),
    *("contact", "contact_residual", "contact_time", DISTANCE, FAR, DISAGREEMENT),
}


def shape_wires(
    estimator: System, finger: Finger, period: float, monitors: Mapping[str, System] = MappingProxyType({})
) -> NamedWires:
    """An estimator, preceded by DrivingTorque and monitors, and followed by FingerShape unless it outputs the pose.

    `monitors` are blocks by the quantity whose usable readings they put out.

    Raises:
        InputError: if the estimator does not estimate the joint angles of the finger.
    """
    shape = FingerShape(finger)
    wires = NamedWires()
    _check_outputs(estimator, finger.segments, shape)
    others = (name for name in finger.driven_deformations if name != "bending")
    deformations = [name for name in others if driving_port(name) in inputs(estimator)]
    wires.add(DRIVING_TORQUE, DrivingTorque(finger, period, deformations), later={ANGLES})
    for quantity, monitor in monitors.items():
        wires.add(f"{quantity}_monitor", monitor)
    wires.add("estimator", estimator, {quantity: usable(quantity) for quantity in monitors})
    if not vector_outputs(shape).keys() <= vector_outputs(estimator).keys():
        wires.add("shape", shape)
    return wires


def _check_outputs(estimator: System, joints: int, shape: FingerShape) -> None:
    outputs = vector_outputs(estimator)
    if outputs.keys() & _RESERVED_OUTPUTS:
        reserved_names = ", ".join(sorted(outputs.keys() & _RESERVED_OUTPUTS))
        raise InputError("estimator", "output ports", reserved_names, "are names of outputs of other blocks")
    sizes = {name: port.size() for name, port in vector_outputs(shape).items()} | {"external_torque": joints}
    for name, size in sizes.items():
        if name != "arcs" and name in outputs and outputs[name].size() != size:
            raise InputError("estimator", f"output port '{name}'", outputs[name].size(), f"give it {size} entries")
    if ANGLES not in outputs or outputs[ANGLES].size() != joints:
        listed_outputs = ", ".join(f"{name} ({port.size()})" for name, port in outputs.items()) or "none"
        raise InputError("estimator", "output ports", listed_outputs, f"output '{ANGLES}' ({joints}) rad")


def add_estimation(
    builder: DiagramBuilder,
    name: str,
    layout: MeasurementModel,
    config: EstimatorConfig,
    sensor: SensorConfig,
    gravity: Array,
    measured: Mapping[str, OutputPort],
    make_estimator: MakeEstimator | None = None,
) -> Ports:
    """Adds `{name}.estimation` for the finger with that name.

    Args:
        builder: of any diagram; a plant is not needed.
        name: of the finger.
        layout: the nominal sensors and finger.
        config: the `estimator` part of a scenario.
        sensor: the `sensor` part: the sampling period, and errors from which the uncertainty follows.
        gravity: gravity in the world, (3,) m/s^2.
        measured: the outputs of the sensors, `sampled_pressure` (C) Pa, `sampled_tension` (T) N and `X_WB` (12).
        make_estimator: replaces the estimator named by `config.type`, see `named_estimators`.

    Returns:
        the signals, by name without the finger's prefix.

    Raises:
        InputError: if the estimator requires an unknown signal, or its shape does not fit this finger.
    """
    return add_estimations(
        builder, {name: layout}, config, sensor, gravity, {name: measured}, make_estimator, composed=False
    )[name]


def add_estimations(
    builder: DiagramBuilder,
    layouts: Mapping[str, MeasurementModel],
    config: EstimatorConfig,
    sensor: SensorConfig,
    gravity: Array,
    measured: Mapping[str, Mapping[str, OutputPort]],
    make_estimator: MakeEstimator | None = None,
    composed: bool = True,
) -> dict[str, Ports]:
    """Adds the estimation of several fingers, by name; arguments and errors as for `add_estimation`.

    `composed`: that of each is one block, and that of equal fingers the same one, unless the estimator is a user's own.
    """
    made_by = name_of(make_estimator, config.type)
    estimations = {
        name: make_estimation(layout, config, sensor, gravity, make_estimator) for name, layout in layouts.items()
    }
    keys = {name: layout.unnamed for name, layout in layouts.items()}
    parts = add_parts(builder, "estimation", estimations, keys if composed and not is_own(made_by) else None)
    with blamed_on("estimator.type", made_by):
        for name, part in parts.items():
            connect_by_name(builder, part.inputs, estimation_inputs(measured[name]), "estimator")
    return {name: part.outputs for name, part in parts.items()}


def make_estimation(
    layout: MeasurementModel,
    config: EstimatorConfig,
    sensor: SensorConfig,
    gravity: Array,
    make_estimator: MakeEstimator | None = None,
) -> FingerEstimation:
    """The estimation of a finger, in no diagram yet; arguments and errors as for `add_estimation`."""
    period = sensor.period
    estimator_stds = uncertainty(config, sensor, layout.calibrated)
    make = make_estimator or find_estimator(config.type, estimator_stds)
    compensated = np.asarray(gravity, dtype=float) * config.compensate_gravity
    made_by = ("estimator.type", name_of(make_estimator, config.type))
    estimator = make_block(*made_by, make, layout, compensated, period)
    monitor = make_monitor(layout, config, sensor, compensated)
    with blamed_on(*made_by):
        return FingerEstimation(estimator, layout, compensated, period, config.contact_threshold, monitor)


def make_monitor(
    layout: MeasurementModel, config: EstimatorConfig, sensor: SensorConfig, gravity: Array
) -> System | None:
    """The block that judges the readings before an estimator takes them, of an extra, if a field of the scenario asks.

    An extra names it as `MONITORS = {field: "module:function"}` in its `adds`, by a field that it adds to `estimator`;
    the function takes these arguments. The block puts out the `usable` readings, NaN where they are not.
    """
    make = next((make for field, make in registered("MONITORS").items() if getattr(config, field)), None)
    return None if make is None else make(layout, config, sensor, gravity)


def usable(quantity: str) -> str:
    """Name of the port with the readings that a monitor judges usable."""
    return f"usable_{quantity}"


def estimation_inputs(measured: Mapping[str, OutputPort]) -> Ports:
    """The measured signals available to an estimator: sampled pressure and tension, but no ground truth."""
    truth = ("joint_angles", TRUE_JOINTS, TRUE_TIP)
    available = {name: port for name, port in measured.items() if name not in truth and not name.startswith(IDEAL)}
    driving = {kind: f"sampled_{kind}" for kind in ("pressure", "tension")}
    return available | {kind: measured[name] for kind, name in driving.items() if name in measured}
