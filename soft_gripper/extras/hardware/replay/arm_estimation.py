"""Builds the diagram of a replay: recorded readings of an arm, T samples -> the blocks of the estimation -> errors.

The sections of an arm bend and lengthen, with rigid parts between them.

The joints of a section share its length; behind every section lies a rigid part, and to its end a body is fixed. In
planar vectors z + i x (see `kinematics`), with h_s the heading at the end of section s,

    e_s = p_base + exp(i tilt) chain_s + sum over sections r before s of  d_r exp(i h_r) ,
    p_s = e_s + m_s exp(i h_s) ,

where chain_s is the end of section s along the stretched chain.

Leading axes are free; S sections, N joints.

The lengthening of an arm bypasses its estimators, from the wires to `StretchedArm`: a bending finger is inextensible,
and its joint angles do not depend on length.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, DiscreteValues, LeafSystem
from pydrake.systems.primitives import Adder, ConstantVectorSource, MatrixGain

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.private_run import remove_unread_blocks
from soft_gripper.diagrams.recording import Recording, read_logs
from soft_gripper.diagrams.signal_logs import add_logs
from soft_gripper.diagrams.wiring.composed import add_part
from soft_gripper.diagrams.wiring.named_wires import NamedWires, connect_by_name
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE, DrivingTorque
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.estimators.named_estimators import find_estimator
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.hardware.recordings import HardwareRecording
from soft_gripper.extras.hardware.replay.wire_lengths import Sections, WireGeometry, as_strain
from soft_gripper.files.document import require, require_value
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar, as_points, forward_kinematics, rotated
from soft_gripper.registry import make_block
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.signals import XZ, describe


@dataclass(frozen=True)
class RigidParts:
    """The rigid parts of an arm."""

    base: Planar | complex  # m, origin of the first section in B
    tilt: float  # rad, of the first section in B
    couplings: Planar  # (S,) m, d: from the end of a section to the beginning of the next
    bodies: Planar  # (S,) m, m: from the end of a section to the body that is fixed there
    turns: Array  # (S,) rad, of the axes of the bodies from the headings of their sections


def stretched_arm(
    parts: RigidParts, q: Array, lengths: Array, section_ends: NDArray[np.int_]
) -> tuple[Planar, Planar, Array]:
    """Joints (..., N) m, bodies (..., S) m, both in B, and headings of the bodies (..., S) rad.

    At joint angles q, (..., N) rad, and lengths of the sections, (..., S) m; `section_ends` are the joints up to the
    end of every section, from 0 to N, (S + 1,).
    """
    joints = np.diff(section_ends)
    chain = forward_kinematics(q, np.repeat(lengths / joints, joints, axis=-1))
    headings = parts.tilt + chain.headings[..., section_ends[1:]]
    shifts = rotated(parts.couplings, headings)
    rigid_shifts = shifts.cumsum(axis=-1) - shifts
    ends = parts.base + rotated(chain.segment_ends[..., section_ends[1:]], parts.tilt) + rigid_shifts
    joint_positions = parts.base + rotated(chain.joints, parts.tilt) + np.repeat(rigid_shifts, joints, axis=-1)
    return joint_positions, ends + rotated(parts.bodies, headings), headings + parts.turns


class StretchedArm(LeafSystem):
    """The positions of joints and bodies of an arm that lengthens, and the errors of the bodies.

    ::

        estimated_joint_angles (N) rad ---> +--------------+ ---> joint_positions  (N x 2) x, z; m in B
        section_lengths (S) m ------------> | StretchedArm | ---> body_positions   (S x 2) x, z; m in B
        measured_bodies (S x 2) m in B ---> +--------------+ ---> body_error       (S) m

    Matrices are passed row by row. Stateless.
    """

    def __init__(self, parts: RigidParts, finger: Finger, bodies: Sequence[str], arcs: SensorLayout | None = None):
        """`arcs`: sensors whose sections are arcs, for any joint angles within them; None: these angles count."""
        super().__init__()
        self._parts, self._arcs, self._ends = parts, arcs, finger.section_ends(len(bodies))
        joints = range(finger.segments)
        self._angles = self.DeclareVectorInputPort(ANGLES, finger.segments)
        self._lengths = self.DeclareVectorInputPort("section_lengths", len(bodies))
        self._measured = self.DeclareVectorInputPort("measured_bodies", 2 * len(bodies))
        shape = {self._angles.ticket(), self._lengths.ticket()}
        positions = self.DeclareVectorOutputPort("joint_positions", 2 * len(joints), self._calc_joints, shape)
        describe(positions, "m", joint=joints, xz=XZ)
        body_positions = self.DeclareVectorOutputPort("body_positions", 2 * len(bodies), self._calc_bodies, shape)
        describe(body_positions, "m", body=bodies, xz=XZ)
        errors = self.DeclareVectorOutputPort("body_error", len(bodies), self._calc_error)
        describe(errors, "m", body=bodies)

    def _points(self, context: Context) -> tuple[np.ndarray, np.ndarray]:
        q = self._angles.Eval(context)
        q = q if self._arcs is None else self._arcs.shared_equally(self._arcs.sums(q))
        joints, bodies, _ = stretched_arm(self._parts, q, self._lengths.Eval(context), self._ends)
        return as_points(joints), as_points(bodies)

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._points(context)[0].ravel())

    def _calc_bodies(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._points(context)[1].ravel())

    def _calc_error(self, context: Context, output: BasicVector) -> None:
        error = self._points(context)[1].ravel() - self._measured.Eval(context)
        output.SetFromVector(np.linalg.norm(error.reshape(-1, 2), axis=1))


class LogSource(LeafSystem):
    """Outputs recorded samples.

    ::

        +-----------+
        | LogSource | ---> {signal}  (entries of the signal)
        +-----------+

    Sampled in discrete state every period, from time 0, like a sensor; the last sample is held.
    """

    def __init__(self, signal: str, samples: Array, period: float, unit: str | Sequence[str], **axes: Sequence[Any]):
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
    """Computes strain and length of an arm of S sections from its wires.

    ::

                                +------------+ ---> strain           (2 x sections) as of an arm that only bends
        wire_lengths (2 x S) m  | WireStrain |
          [inner; outer] -----> +------------+ ---> section_lengths  (S) m

    Estimators bend a finger of constant length; the lengths bypass them, to StretchedArm. Stateless.
    """

    def __init__(self, geometry: WireGeometry, finger: Finger, sections: int):
        """`sections` of the strain sensors, which divides S."""
        super().__init__()
        self._geometry, self._finger, self._sections = geometry, finger, sections
        arm_sections = len(geometry.bend_offsets)
        self._wires = self.DeclareVectorInputPort("wire_lengths", 2 * arm_sections)
        strain = self.DeclareVectorOutputPort("strain", 2 * sections, self._calc_strain)
        describe(strain, path=PATHS, section=range(sections))
        lengths = self.DeclareVectorOutputPort("section_lengths", arm_sections, self._calc_lengths)
        describe(lengths, "m", arm_section=range(arm_sections))

    def _calc_strain(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(as_strain(self._finger, self._find_sections(context).theta, self._sections)[1])

    def _calc_lengths(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._find_sections(context).length)

    def _find_sections(self, context: Context) -> Sections:
        return self._geometry.sections(*np.asarray(self._wires.Eval(context)).reshape(2, -1))


@dataclass(frozen=True)
class NominalArm:
    """Nominal model of an arm of S sections, C chambers and N joints."""

    finger: Finger  # with creep
    gains: Array  # (N, C) N m/Pa, torque per pressure
    rest: Array  # (N,) N m, torque without pressure
    wires: WireGeometry
    parts: RigidParts
    uncertainty: Uncertainty
    gravity: Array  # (3,) m/s^2 in B


@dataclass(frozen=True)
class ReplayInputs:
    """T recorded samples, `period` s apart."""

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

    def __init__(self, arm: NominalArm, estimator: str, sections: int, bodies: Sequence[str], period: float):
        """Builds an estimator by its name, with the number of sensors per side."""
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
        X_WB = np.append(np.eye(3).ravel(), np.zeros(3))
        wires.add("base", ConstantVectorSource(X_WB), {"y0": "X_WB"})  # gravity is given in B
        make = find_estimator(estimator, arm.uncertainty, "--estimator")
        wires.add("estimator", make_block("--estimator", estimator, make, layout, arm.gravity, period))
        arcs = layout if estimator == "arcs" else None
        shared = {ANGLES, DRIVING_TORQUE, "strain", "section_lengths"}
        for name in wires.outputs.keys() - shared:
            del wires.outputs[name]
        wires.add("arm", StretchedArm(arm.parts, arm.finger, bodies, arcs))
        wires.build_into(self)


def estimate_recording(
    arm: NominalArm, inputs: ReplayInputs, estimators: Mapping[str, tuple[str, int]], about: Mapping[str, str]
) -> Recording:
    """Feeds recorded readings of an arm to estimators, each with its sensors per side, by the name of the row.

    The result has the signals of each estimation, `{row}.{signal}`, the recorded ones, and the attributes `about`.
    """
    builder = DiagramBuilder()
    sections, chambers = range(inputs.wire_lengths.shape[2]), range(inputs.pressures.shape[1])
    sources: dict[str, tuple[str, Array, dict[str, Sequence[Any]]]] = {
        "wire_lengths": ("m", inputs.wire_lengths, {"path": PATHS, "arm_section": sections}),
        "pressures": ("Pa", inputs.pressures, {"chamber": chambers}),
        "measured_bodies": ("m", inputs.measured_bodies, {"body": list(inputs.bodies), "xz": XZ}),
    }
    recorded_signals = {}
    for name, (unit, samples, axes) in sources.items():
        source = builder.AddNamedSystem(name, LogSource(name, samples, inputs.period, unit, **axes))
        recorded_signals[name] = source.get_output_port()
    signals = dict(recorded_signals)
    for row, (estimator, count) in estimators.items():
        estimation = ArmEstimation(arm, estimator, count, inputs.bodies, inputs.period)
        added_part = add_part(builder, row, estimation)
        connect_by_name(builder, added_part.inputs, recorded_signals, "estimation")
        signals |= {f"{row}.{name}": port for name, port in added_part.outputs.items()}
    logs = add_logs(builder, signals, inputs.period)
    remove_unread_blocks(builder, signals)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo((len(inputs.pressures) - 1) * inputs.period)
    return read_logs(logs, simulator.get_context(), about)


PERIOD = 0.02  # s, between samples; rows are held
MAX_TIME = 3600.0  # s, of a recording


@dataclass(frozen=True)
class ArmRecording:
    """T samples, PERIOD apart, of an arm with S sections and C chambers; NaN where a body is not seen."""

    name: str
    spacing: float  # m, between the wires of the two sides
    time: Array  # (T,) s, from 0
    inner: Array  # (T, S) m, wires from the base to the end of each section
    outer: Array  # (T, S) m
    pressures: Array  # (T, C) Pa
    chamber_sections: tuple[int, ...]  # (C,) that each chamber is in, from 0
    bodies: tuple[str, ...]  # S names, from the base to the tip
    positions: Planar  # (T, S) m in B, of the bodies
    headings: Array  # (T, S) rad


def arm_recording(recording: HardwareRecording) -> ArmRecording:
    """Resamples a recording of an arm that has two wires and a body per section, and pressures."""
    recording_name, expected = recording.name, "an arm is estimated from length sensors: describe them"
    described = require_value(recording.config.lengths, recording_name, "lengths", expected)
    measured = require_value(recording.pressures, recording_name, "pressures", "describe the chambers' pressures")
    wires = {(wire.side, wire.section): recording.lengths[name] for name, wire in described.wires.items()}
    sections = range(1, max(section for _, section in wires) + 1)
    expected = "give two wires that end at each section, on the inner and on the outer side"
    is_complete = set(wires) == {(side, section) for side in ("inner", "outer") for section in sections}
    require(is_complete, recording_name, "lengths.wires", list(described.wires), expected)
    poses = {name: pose for name, pose in recording.poses.items() if name != "base"}
    bodies = sorted(poses, key=lambda name: float(np.nanmedian(poses[name].p[:, 2])))
    expected = f"give a body for the end of each of the {len(sections)} sections, besides 'base'"
    require(len(bodies) == len(sections), recording_name, "poses", bodies, expected)
    pressures = recording.config.pressures
    chamber_sections = (pressures.sections if pressures else None) or []
    is_described = len(chamber_sections) == measured.shape[1] and set(chamber_sections) <= set(sections)
    expected = f"give the section of each chamber, of {len(sections)}"
    require(is_described, recording_name, "pressures.sections", chamber_sections, expected)
    has_readings = np.isfinite(np.column_stack([*wires.values(), measured])).all(axis=1)
    require(bool(has_readings.any()), recording_name, "lengths, pressures", None, "no row has all of them")
    seconds = recording.time[has_readings] - recording.time[has_readings][0]
    expected = f"lasts longer than {MAX_TIME:g} s, the limit of {MAX_TIME / PERIOD:g} samples: cut it"
    require(seconds[-1] <= MAX_TIME, recording_name, "time", float(seconds[-1]), expected)
    time = np.arange(0.0, seconds[-1], PERIOD)
    rows = np.flatnonzero(has_readings)[np.searchsorted(seconds, time + 1e-9, side="right") - 1]
    return ArmRecording(
        name=recording.name,
        spacing=described.spacing,
        time=time,
        inner=np.column_stack([wires["inner", section] for section in sections])[rows],
        outer=np.column_stack([wires["outer", section] for section in sections])[rows],
        pressures=measured[rows],
        chamber_sections=tuple(section - 1 for section in chamber_sections),
        bodies=tuple(bodies),
        positions=np.column_stack([as_planar(poses[name].p[:, ::2]) for name in bodies])[rows],
        headings=np.column_stack([_heading(poses[name].R) for name in bodies])[rows],
    )


def _heading(R: Array) -> Array:
    """Direction of a body's z axis in the bending plane, rad, less multiples of pi.

    Motion capture sometimes reports a body with symmetric markers rotated by 180 degrees: an axis has no sign.
    """
    heading: Array = np.arctan2(R[:, 0, 2], R[:, 2, 2])
    known_headings = np.isfinite(heading)
    if known_headings.any():
        angle = np.unwrap(heading[known_headings], period=np.pi)
        heading[known_headings] = angle - np.pi * np.round(angle[0] / np.pi)
    return heading
