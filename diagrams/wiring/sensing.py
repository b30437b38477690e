"""Sensing, applied: sensors, estimation and, optionally, scoring of the fingers of a plant.

A finger has three sub-diagrams: sensors, estimation and scoring. Estimation has no connection to the ground truth, so
that recorded signals can feed it. Signals named `ideal_*` are ground truth, and `add_estimation` does not offer them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper.diagrams.wiring.composed import add_parts
from soft_gripper.diagrams.wiring.drive import check_finalized
from soft_gripper.diagrams.wiring.estimation import add_estimations
from soft_gripper.diagrams.wiring.grip_control import find_gripper, forms_gripper
from soft_gripper.diagrams.wiring.named_wires import Ports, inputs
from soft_gripper.diagrams.wiring.scoring import (
    add_alongside,
    add_scoring,
    add_true_contact,
    add_true_poses,
    add_width_error,
)
from soft_gripper.diagrams.wiring.sensors import connect_sensors, make_sensors
from soft_gripper.errors import InputError, suggestion
from soft_gripper.estimators.named_estimators import MakeEstimator
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.load.opening import Gripper, ObjectWidth
from soft_gripper.registry import is_own, name_of
from soft_gripper.scenario.nominal_model import NominalModel
from soft_gripper.scenario.schema import EstimatorConfig, RecordConfig, SensorConfig
from soft_gripper.scenario.sensor_presets import ALL, MakeSensor, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP


def add_object_width(
    builder: DiagramBuilder, gripper: Gripper, nominal: Mapping[str, Finger], signals: Mapping[str, OutputPort]
) -> OutputPort:
    """Adds `object_width` for the `nominal` fingers of one gripper, in its order by their names; returns it, (1) m.

    `signals` has `{finger}.estimated_joint_angles` and `{finger}.contact`.
    """
    width = ObjectWidth(gripper, nominal)
    builder.AddNamedSystem("object_width", width)
    for name, port in inputs(width).items():
        builder.Connect(signals[name], port)
    return width.get_output_port()


@dataclass(frozen=True)
class SensingConfig:
    """The parts of a scenario that configure measurement and estimation, and user blocks."""

    sensor: SensorConfig = field(default_factory=SensorConfig)
    estimator: EstimatorConfig = field(default_factory=EstimatorConfig)
    nominal: NominalModel = field(default_factory=NominalModel)  # see `read_nominal_model`
    make_sensor: MakeSensor | None = None  # in the place of the sensor that `sensor.type` names
    make_estimator: MakeEstimator | None = None  # in the place of the estimator that `estimator.type` names
    record: RecordConfig = field(default_factory=RecordConfig)  # which ground truth is added
    composed: bool = False  # where nobody reads the blocks: see `wiring.composed`


def add_sensing(
    builder: DiagramBuilder,
    fingers: Sequence[PlantFinger],
    pressures: Mapping[str, OutputPort],
    config: SensingConfig | None = None,
    tensions: Mapping[str, OutputPort] | None = None,
) -> Ports:
    """Adds `{finger}.sensors`, `{finger}.estimation` and `{finger}.scoring` for each finger, and one `true_contact`.

    If contact is detected and the fingers form one gripper, also adds `object_width` and its error.

    Args:
        builder: builder of a diagram with the fingers' plant.
        fingers: fingers in the finalized plant.
        pressures: pressures in the chambers, (C) Pa, by finger name; see `add_pressure_drive`.
        config: the configuration of sensing.
        tensions: of the tendons, (T) N, by finger name; None: there are none.

    Returns:
        the signals, `{finger}.{signal}`; for the fingers of one gripper, also `grip.true_object_width`.

    Raises:
        InputError: if a sensor, an estimator or a nominal model is wrong.
    """
    config = config or SensingConfig()
    check_finalized(fingers)
    _check_faults(fingers, config.sensor)
    if not fingers:
        return {}
    is_scored = config.record.truth != "none"
    signals = add_true_poses(builder, fingers, config.sensor.period) if is_scored else {}
    layouts = {finger.name: config.nominal.layout(finger.finger, config.sensor) for finger in fingers}
    driving = {finger.name: _driving(finger, pressures, tensions or {}) for finger in fingers}
    measurements = _add_sensors(builder, fingers, driving, config)
    gravity = np.array(fingers[0].plant.gravity_field().gravity_vector())
    estimated = add_estimations(
        builder, layouts, config.estimator, config.sensor, gravity, measurements, config.make_estimator, config.composed
    )
    for finger in fingers:
        name = finger.name
        truth = {true_signal: signals[f"{name}.{true_signal}"] for true_signal in (TRUE_JOINTS, TRUE_TIP) if is_scored}
        finger_signals = _with_truth(builder, finger, layouts[name], measurements[name], estimated[name], truth, config)
        signals |= {f"{name}.{signal}": port for signal, port in {**driving[name], **finger_signals}.items()}
    true_width = _add_true_contact(builder, fingers, config, signals)
    if not forms_gripper(fingers):
        return signals
    if true_width is not None:
        signals["grip.true_object_width"] = true_width
    if config.estimator.contact_threshold is not None:
        nominal = {name: layout.finger for name, layout in layouts.items()}
        gripper = find_gripper(fingers, "estimator.contact_threshold")
        width = signals["grip.object_width"] = add_object_width(builder, gripper, nominal, signals)
        if true_width is not None:
            signals["grip.object_width_error"] = add_width_error(builder, width, true_width)
    return signals


def _check_faults(fingers: Sequence[PlantFinger], config: SensorConfig) -> None:
    """Raises an InputError if a sensor that fails is on no finger."""
    finger_names = [finger.name for finger in fingers]
    for i, fault in enumerate(config.faults):
        if fault.finger not in (*finger_names, ALL):
            expected = f"no such finger; {suggestion(fault.finger, (*finger_names, ALL))}"
            raise InputError("sensor", f"faults[{i}].finger", fault.finger, expected)


def _add_true_contact(
    builder: DiagramBuilder, fingers: Sequence[PlantFinger], config: SensingConfig, signals: Ports
) -> OutputPort | None:
    """Adds the patches of contact if they are recorded, and their signals; returns the held object's true width."""
    stride = config.record.patches_every
    if stride is None:
        return None
    truth = add_true_contact(builder, fingers, None if stride == 1 else stride * config.sensor.period)
    width = truth.pop("width")
    signals |= truth
    return width


def _driving(finger: PlantFinger, pressures: Mapping[str, OutputPort], tensions: Mapping[str, OutputPort]) -> Ports:
    """The signals that drive a finger, by kind."""
    driving = {}
    for kind, field_, ports, is_needed in (
        ("pressure", "pressures", pressures, finger.finger.pressures),
        ("tension", "tensions", tensions, finger.finger.tendons),
    ):
        if finger.name in ports:
            driving[kind] = ports[finger.name]
        elif is_needed:
            raise InputError("add_sensing", field_, list(ports), f"has no entry for finger '{finger.name}'")
    return driving


def _add_sensors(
    builder: DiagramBuilder, fingers: Sequence[PlantFinger], driving: Mapping[str, Ports], config: SensingConfig
) -> dict[str, Ports]:
    """Adds the sensors; returns the measured signals of each finger."""
    sensor = config.sensor
    made_by = name_of(config.make_sensor, config.sensor.type)
    finger_sensors = {finger.name: make_sensors(finger.finger, sensor, config.make_sensor) for finger in fingers}
    keys = {finger.name: (finger.finger.unnamed, strain_errors(sensor, finger.name)) for finger in fingers}
    parts = add_parts(builder, "sensors", finger_sensors, keys if config.composed and not is_own(made_by) else None)
    drives = {name: (ports.get("pressure"), ports.get("tension")) for name, ports in driving.items()}
    return {
        finger.name: connect_sensors(builder, finger, parts[finger.name], sensor, *drives[finger.name], made_by)
        for finger in fingers
    }


def _with_truth(
    builder: DiagramBuilder,
    finger: PlantFinger,
    nominal: MeasurementModel,
    measured: Ports,
    estimated: Ports,
    truth: Ports,
    config: SensingConfig,
) -> Ports:
    """Joins all signals of a finger: measured, estimated, scored against ground truth, and estimated alongside."""
    sensor = config.sensor
    signals = {**measured, **estimated}
    scores = add_scoring(builder, finger, sensor.period, signals | truth) if truth else {}
    alongside = add_alongside(builder, finger, nominal, config.estimator, sensor, measured | truth)
    repeated_names = (measured.keys() & estimated.keys()) | (signals.keys() & {*scores, *truth, "pressure", "tension"})
    if repeated_names:
        raise InputError("finger", "output ports", ", ".join(sorted(repeated_names)), "have the name of another signal")
    del signals["joint_angles"]  # of every step of the plant; what is sampled is logged
    return {**signals, **scores, **alongside}
