"""Sensing, applied: sensors, estimation and, where it is wanted, scoring of the fingers of a plant."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from soft_gripper.diagrams.wiring.belief import believed_layout
from soft_gripper.diagrams.wiring.choices import MakeEstimator, MakeSensor
from soft_gripper.diagrams.wiring.drive import check_finalized
from soft_gripper.diagrams.wiring.estimation import add_estimation
from soft_gripper.diagrams.wiring.grip_control import find_gripper, forms_gripper
from soft_gripper.diagrams.wiring.named_wires import Ports, inputs
from soft_gripper.diagrams.wiring.scoring import (
    add_beside,
    add_scoring,
    add_true_contact,
    add_true_poses,
    add_width_error,
)
from soft_gripper.diagrams.wiring.sensors import add_sensors
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.load.gripper_opening import Gripper
from soft_gripper.load.object_width import ObjectWidth
from soft_gripper.scenario.scenario import BelievedConfig, EstimatorConfig, SensorConfig
from soft_gripper.scenario.sensor_presets import uncertainty
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP


def add_object_width(
    builder: DiagramBuilder, gripper: Gripper, believed: Mapping[str, Finger], signals: Mapping[str, OutputPort]
) -> OutputPort:
    """Adds `object_width` for the fingers of one gripper; returns the width, (1) m.

    Args:
        builder: of any diagram.
        gripper: where the fingers stand.
        believed: the fingers as they are believed to be, in the order of the gripper, by their names.
        signals: has `{finger}.estimated_joint_angles` and `{finger}.contact`.
    """
    width = ObjectWidth(gripper, believed)
    builder.AddNamedSystem("object_width", width)
    for name, port in inputs(width).items():
        builder.Connect(signals[name], port)
    return width.get_output_port()


@dataclass(frozen=True)
class SensingConfig:
    """The parts of a scenario that say what is measured and estimated, and blocks of the user's own."""

    sensor: SensorConfig = field(default_factory=SensorConfig)
    estimator: EstimatorConfig = field(default_factory=EstimatorConfig)
    believed: BelievedConfig = field(default_factory=BelievedConfig)
    make_sensor: MakeSensor | None = None  # in the place of the sensor that `sensor.type` names
    make_estimator: MakeEstimator | None = None  # in the place of the estimator that `estimator.type` names


def add_sensing(
    builder: DiagramBuilder,
    fingers: Sequence[PlantFinger],
    pressures: Mapping[str, OutputPort],
    config: SensingConfig | None = None,
) -> Ports:
    """Adds for every finger `{finger}.sensors`, `{finger}.estimation` and `{finger}.scoring`; for all `true_contact`.

    Args:
        builder: of a diagram with the fingers' plant.
        fingers: in the finalized plant.
        pressures: in the chambers, (1) Pa, by the names of the fingers; see `add_pressure_drive`.
        config: what is measured and estimated.

    Returns:
        the signals, `{finger}.{signal}`; of the fingers of one gripper `grip.true_object_width` too.

    Raises:
        InputError: if a sensor, an estimator or a belief is wrong.
    """
    config = config or SensingConfig()
    check_finalized(fingers)
    signals = add_true_poses(builder, fingers, config.sensor.period) if fingers else {}
    for finger in fingers:
        if finger.name not in pressures:
            raise InputError("add_sensing", "pressures", list(pressures), f"has none for finger '{finger.name}'")
        truth = {name: signals[f"{finger.name}.{name}"] for name in (TRUE_JOINTS, TRUE_TIP)}
        found = _sense(builder, finger, pressures[finger.name], truth, config)
        signals |= {f"{finger.name}.{name}": port for name, port in found.items()}
    return signals | (_truth_of_contact(builder, fingers) if fingers else {})


def _truth_of_contact(builder: DiagramBuilder, fingers: Sequence[PlantFinger]) -> Ports:
    truth = add_true_contact(builder, fingers)
    width = truth.pop("width")
    return truth | ({"grip.true_object_width": width} if forms_gripper(fingers) else {})


def _sense(
    builder: DiagramBuilder, finger: PlantFinger, pressure: OutputPort, truth: Ports, config: SensingConfig
) -> Ports:
    sensor, make = config.sensor, config.make_estimator
    estimator = replace(config.estimator, uncertainty=uncertainty(config.estimator, sensor))
    gravity = np.array(finger.plant.gravity_field().gravity_vector())
    layout = believed_layout(finger.finger, sensor, config.believed)
    measured = add_sensors(builder, finger, sensor, pressure, config.make_sensor)
    estimated = add_estimation(builder, finger.name, layout, estimator, sensor.period, gravity, measured, make)
    known = {**measured, **estimated}
    scores = add_scoring(builder, finger, sensor.period, known | truth)
    beside = add_beside(builder, finger, layout, estimator, sensor.period, measured | truth)
    twice = (measured.keys() & estimated.keys()) | (known.keys() & {*scores, *truth, "pressure"})
    if twice:
        raise InputError("finger", "output ports", ", ".join(sorted(twice)), "have the name of another signal")
    del known["joint_angles"]  # of every step of the plant; what is sampled is logged
    return {"pressure": pressure, **known, **scores, **beside}


def add_contact_width(
    builder: DiagramBuilder,
    fingers: Sequence[PlantFinger],
    signals: Mapping[str, OutputPort],
    config: SensingConfig,
) -> Ports:
    """Adds, for the fingers of one gripper, `object_width` and its error; returns the signals.

    `signals` are those of `add_sensing` with contact looked for.
    """
    if not forms_gripper(fingers):
        return {}
    believed = {f.name: believed_layout(f.finger, config.sensor, config.believed).finger for f in fingers}
    gripper = find_gripper(fingers, "estimator.contact_threshold")
    width = add_object_width(builder, gripper, believed, signals)
    error = add_width_error(builder, width, signals["grip.true_object_width"])
    return {"grip.object_width": width, "grip.object_width_error": error}
