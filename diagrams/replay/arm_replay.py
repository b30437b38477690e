"""The diagram of a replay: recorded readings of an arm -> the blocks of the estimation -> scores."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording, read_logs
from soft_gripper.diagrams.recording.signal_logs import add_logs
from soft_gripper.diagrams.replay.log_source import LogSource
from soft_gripper.diagrams.replay.stretched_arm_block import StretchedArm
from soft_gripper.diagrams.replay.wire_strain import PATHS, WireStrain
from soft_gripper.diagrams.wiring.choices import find_estimator, make_block
from soft_gripper.diagrams.wiring.named_wires import NamedWires, connect_known, vector_outputs
from soft_gripper.fingers.finger import Finger
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.wire_lengths import WireCalibration
from soft_gripper.shape.driving_torque import DRIVING_TORQUE, DrivingTorque
from soft_gripper.shape.finger_shape import ANGLES
from soft_gripper.shape.stretched_arm import RigidParts
from soft_gripper.shape.uncertainty import Uncertainty
from soft_gripper.signals import XZ, describe


@dataclass(frozen=True)
class BelievedArm:
    """An arm of S sections, C chambers and N joints, as its estimators believe it to be."""

    finger: Finger  # with creep
    gains: Array  # (N, C) N m/Pa, torque per pressure
    rest: Array  # (N,) N m, torque without pressure
    wires: WireCalibration
    parts: RigidParts
    uncertainty: Uncertainty
    gravity: Array  # (3,) m/s^2 in B


@dataclass(frozen=True)
class Readings:
    """T samples, `period` s apart, of what was recorded."""

    period: float
    wire_lengths: Array  # (T, 2, S) m, inner and outer, from the base to the end of each section
    pressures: Array  # (T, C) Pa
    bodies: Sequence[str]  # (S,) names
    measured_bodies: Array  # (T, S, 2) m, x and z in B


class ArmEstimation(Diagram):
    """One estimator of an arm, from its readings to the places of its bodies.

    ::

        wire_lengths --> WireStrain --> strain --> estimator --> estimated_joint_angles --> StretchedArm --> places,
                             |                        ^               |                      ^    ^          errors
                             +--- section_lengths ----|---------------|----------------------+    |
        pressures --> chambers --> driving torque ----+               |                           |
                          memory of creep --^-------------------------+                           |
        measured_bodies --------------------------------------------------------------------------+
    """

    def __init__(self, arm: BelievedArm, estimator: str, sections: int, bodies: Sequence[str], period: float):
        """An estimator by its name with so many sensors a side.

        Raises:
            InputError: if there is none of that name.
        """
        super().__init__()
        layout, joints = SensorLayout(arm.finger, sections), arm.finger.segments
        wires = NamedWires()
        wires.add("wire_strain", WireStrain(arm.wires, arm.finger, sections))
        wires.add("chambers", MatrixGain(arm.gains), {"u0": "pressures", "y0": "chamber_torque"})
        wires.add("rest", ConstantVectorSource(arm.rest), {"y0": "rest_torque"})
        wires.add("no_pressure", ConstantVectorSource([0.0]), {"y0": "pressure"})
        wires.add("memory", DrivingTorque(arm.finger, period), {DRIVING_TORQUE: "memory_torque"}, later={ANGLES})
        parts = {f"u{i}": name for i, name in enumerate(("chamber_torque", "rest_torque", "memory_torque"))}
        driving = Adder(3, joints)
        wires.add("driving", driving, {**parts, "sum": DRIVING_TORQUE})
        describe(driving.get_output_port(), "N m", joint=range(joints))
        identity = np.append(np.eye(3).ravel(), np.zeros(3))
        wires.add("base", ConstantVectorSource(identity), {"y0": "X_WB"})  # gravity is given in B
        make = find_estimator(estimator, arm.uncertainty, "--estimator")
        wires.add("estimator", make_block("--estimator", estimator, make, layout, arm.gravity, period))
        as_arcs = layout if estimator == "arcs" else None
        kept = {ANGLES, DRIVING_TORQUE, "strain", "section_lengths"}
        for name in wires.outputs.keys() - kept:
            del wires.outputs[name]
        wires.add("arm", StretchedArm(arm.parts, arm.finger, bodies, as_arcs))
        wires.build_into(self)


def replay(
    arm: BelievedArm, readings: Readings, estimators: Mapping[str, tuple[str, int]], about: Mapping[str, str]
) -> Recording:
    """Feeds estimators with what was recorded.

    Args:
        arm: as it is believed to be.
        readings: of one recording.
        estimators: name of an estimator and its sensors a side, by what the row is called.
        about: attributes of the result.

    Returns:
        the signals of every estimation, `{row}.{signal}`, and what was recorded.

    Raises:
        InputError: if there is no such estimator.
    """
    builder = DiagramBuilder()
    sections, chambers = range(readings.wire_lengths.shape[2]), range(readings.pressures.shape[1])
    sources: dict[str, tuple[str, Array, dict[str, Sequence[Any]]]] = {
        "wire_lengths": ("m", readings.wire_lengths, {"path": PATHS, "arm_section": sections}),
        "pressures": ("Pa", readings.pressures, {"chamber": chambers}),
        "measured_bodies": ("m", readings.measured_bodies, {"body": list(readings.bodies), "xz": XZ}),
    }
    known = {}
    for name, (unit, samples, axes) in sources.items():
        source = builder.AddNamedSystem(name, LogSource(name, samples, readings.period, unit, **axes))
        known[name] = source.get_output_port()
    signals = dict(known)
    for row, (estimator, count) in estimators.items():
        estimation = ArmEstimation(arm, estimator, count, readings.bodies, readings.period)
        builder.AddNamedSystem(row, estimation)
        connect_known(builder, estimation, known, "estimation")
        signals |= {f"{row}.{name}": port for name, port in vector_outputs(estimation).items()}
    logs = add_logs(builder, signals, readings.period)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((len(readings.pressures) - 1) * readings.period)
    return read_logs(logs, simulator.get_context(), about)
