"""The diagram of a replay: recorded readings of an arm -> the blocks of the estimation -> scores."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, DiscreteValues, LeafSystem
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording, read_logs
from soft_gripper.diagrams.recording.signal_logs import add_logs
from soft_gripper.diagrams.wiring.named_blocks import find_estimator, make_block
from soft_gripper.diagrams.wiring.named_wires import NamedWires, connect_known, vector_outputs
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE, DrivingTorque
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger import Finger
from soft_gripper.hardware.replay.stretched_arm import RigidParts, StretchedArm
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.wire_lengths import WireCalibration, as_strain
from soft_gripper.signals import XZ, describe


class LogSource(LeafSystem):
    """Outputs recorded samples.

    ::

        +-----------+
        | LogSource | ---> {signal}  (entries of the signal)
        +-----------+

    Sampled in discrete state every period, from time 0, like a sensor; the last sample is held.
    """

    def __init__(self, signal: str, samples: Array, period: float, unit: str, **axes: Sequence[Any]):
        """`samples` (T, ...) every `period` s; unit and axes as for `describe`."""
        super().__init__()
        self._samples, self._period = samples.reshape(len(samples), -1), period
        state = self.DeclareDiscreteState(self._samples.shape[1])
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)
        describe(self.DeclareStateOutputPort(signal, state), unit, **axes)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        row = min(round(context.get_time() / self._period), len(self._samples) - 1)
        values.set_value(np.array(self._samples[row]))


PATHS = ("inner", "outer")


class WireStrain(LeafSystem):
    """Reads an arm of S sections whose wires are calibrated.

    ::

                                +------------+ ---> strain           (2 x sections) as of an arm that only bends
        wire_lengths (2 x S) m  | WireStrain |
          [inner; outer] -----> +------------+ ---> section_lengths  (S) m

    Estimators bend a finger of constant length; the lengths bypass them, to StretchedArm. Stateless.
    """

    def __init__(self, calibration: WireCalibration, finger: Finger, sections: int):
        """`sections` of the strain sensors, which divides S."""
        super().__init__()
        self._calibration, self._finger, self._sections = calibration, finger, sections
        count = len(calibration.bend_offsets)
        self._wires = self.DeclareVectorInputPort("wire_lengths", 2 * count)
        describe(
            self.DeclareVectorOutputPort("strain", 2 * sections, self._calc_strain), path=PATHS, section=range(sections)
        )
        lengths = self.DeclareVectorOutputPort("section_lengths", count, self._calc_lengths)
        describe(lengths, "m", arm_section=range(count))

    def _calc_strain(self, context: Context, output: BasicVector) -> None:
        theta = self._calibration.sections(*self._sides(context)).theta
        output.SetFromVector(as_strain(self._finger, theta, self._sections)[1])

    def _calc_lengths(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._calibration.sections(*self._sides(context)).length)

    def _sides(self, context: Context) -> np.ndarray:
        return np.asarray(self._wires.Eval(context)).reshape(2, -1)


@dataclass(frozen=True)
class BelievedArm:
    """The nominal model of an arm of S sections, C chambers and N joints."""

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
        """An estimator by its name, with the number of sensors per side.

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
    """Feeds recorded readings to estimators.

    Args:
        arm: its nominal model.
        readings: of one recording.
        estimators: name of an estimator and its sensors per side, by the name of the row.
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
