"""Simulates a recording: the chain in Drake, driven like the hardware -> positions of its markers, (T, M) m.

Plant and drive are those of a station, but a chamber fills through an orifice, because a first-order
lag behind the valve cannot rise within 70 ms at 15 kPa and within 190 ms at 35 kPa.

Recordings of the pneumatic segment require that pressure takes a part of the stiffness (`fingers.taken_stiffness`):
with a law for the driving torque alone the tip turned about the same point at every pressure, whereas that point moves
by 6 mm toward the tip, since a segment that hangs is held straight by its weight most at its base; the share of creep
was the same at every pressure, whereas it doubles from 15 to 45 kPa; and a finger that was emptied remembered a part of
the motion in the recordings, since its branches hold the bend, not the stress. Another property of a set-up is a field
of `Setup` and a key of `free_parameters`.
"""

import xml.etree.ElementTree as ET
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.hardware.identification.hung_load import HungLoad
from soft_gripper.extras.hardware.recordings import HardwareRecording
from soft_gripper.files.document import require
from soft_gripper.fingers.creep import shares
from soft_gripper.fingers.cross_section import SIZES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import finger_to_urdf, tip_name
from soft_gripper.fingers.finger_parts import TipLoad
from soft_gripper.fingers.kinematics import as_planar, forward_kinematics, planar_vector, rotated
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.quantity import quantity
from soft_gripper.scenario.schema import PressureConfig

_TIP_BODY = "tip"
_ONSET_SHARE = 0.1  # share of the largest displacement that only an event can cause
_EVENT_SHARE = 0.5  # share of the largest displacement that identifies the rise and fall of the event
_EVENT_MARGIN = 0.05  # s, by which an event may be earlier than it is detected
_CLOSING_SHARE = 0.97  # of the displacement before the valve closes
_MAX_PRESSURE_VARIATION = 0.2  # of the largest pressure, while the valve is open
_RELEASE_TIME = 0.03  # s, initial guess of the time that a hand takes
SETTLED_TIME = 0.2  # s, averaging period of settled values


class Hold(NamedTuple):
    """Pose of a tip in a hand before its release, from the straight finger."""

    sag: float = 0.0  # m, across, toward the inner side
    turn: float = 0.0  # rad


@dataclass(frozen=True)
class MeasuredMotion:
    """Markers of one recording, z + i x in B, m, and the cause of their motion. NaN: not seen."""

    name: str
    time: Array  # (T,) s
    markers: Planar  # (T, M)
    reference: Planar  # (M,) mean of the markers before the event, when the finger is straight
    gravity: Array  # (3,) m/s^2, in B
    pressure: float | None  # Pa, in the chamber between two events; None: let go by a hand between two events
    load: TipLoad | None
    events: tuple[float, float]  # s, of a release, its begin and end; or of the valve, when it opens and closes
    hold: Hold | None = None  # of the hand that let go, to be fitted; None: it held the finger straight
    string: float | None = None  # m, on which the load swings; None: it is fixed to the tip

    @property
    def displacement(self) -> Array:
        """Mean distance of the markers from the reference, m, (T,)."""
        return np.abs(np.nanmean(self.markers - self.reference, axis=1))

    @property
    def largest(self) -> float:
        """Displacement of the markers, m."""
        return float(np.nanmax(self.displacement))

    @property
    def end(self) -> float:
        """End of the settled state, s: the end of the recording, or the closing of the valve."""
        return float(self.time[-1]) if self.pressure is None else self.events[1]

    @property
    def unknowns(self) -> Array:
        """Unknowns as one vector: the times of the events, s, and the held pose, if it is fitted."""
        return np.array((*self.events, *(self.hold or ())))

    def with_unknowns(self, values: Array) -> "MeasuredMotion":
        """Copy with other values of the unknowns."""
        begin, end, *hold = values.tolist()
        return replace(self, events=(begin, end), hold=Hold(*hold) if hold else None)


def measured_motion(recording: HardwareRecording) -> MeasuredMotion:
    """Reads the motion of the tip from a recording.

    Raises:
        InputError: if the recording has no markers on the tip, does not give the cause of motion, or nothing moves.
    """
    config = recording.config
    names = config.markers.bodies.get(_TIP_BODY, []) if config.markers else []
    if len(names) < 2:
        expected = "name at least two markers that are glued to the tip, to measure its rotation"
        expected += "; of a pose, write points that are fixed to its body as columns" if config.poses else ""
        raise InputError(recording.name, "markers.bodies.tip", names, expected)
    if config.event not in ("release", "step"):
        expected = 'give the cause of the motion: "release" or "step"'
        expected += "" if recording.pressures is None else ", with one constant pressure in a file"
        raise InputError(recording.name, "event", config.event, expected)
    if config.event == "step" and recording.commanded_pressure is None:
        expected = "the file name does not give the pressure as described by commanded_pressure"
        remedy = "; a column is not read instead: write a file for each constant pressure"
        expected += "" if recording.pressures is None else remedy
        raise InputError(recording.name, "commanded_pressure", None, expected)
    markers = as_planar(np.stack([recording.markers[name][:, [0, 2]] for name in names], axis=1))
    reference = as_planar(np.stack([recording.reference[name][[0, 2]] for name in names]))
    distances = np.abs(np.nanmean(markers - reference, axis=1))
    begin = _motion_begin(recording, distances)
    events = begin, begin + _RELEASE_TIME  # the end of a release is not observable
    if config.event == "step":
        events = begin, _valve_closing(recording, distances)
        reference = _reference_markers(recording, markers, events[0])
        _check_constant(recording, *events)
    gravity = np.zeros(3) if recording.gravity is None else recording.gravity
    if config.load_string is not None:
        expected = "give it, since a load swings on its load_string"
        require(bool(gravity.any()), recording.name, "gravity", config.gravity, expected)
    return MeasuredMotion(
        name=recording.name,
        time=recording.time,
        markers=markers,
        reference=reference,
        gravity=gravity,
        pressure=recording.commanded_pressure if config.event == "step" else None,
        load=TipLoad(recording.load_mass, *(recording.load_place or (0.0, 0.0))) if recording.load_mass else None,
        events=events,
        string=config.load_string,
    )


def _reference_markers(recording: HardwareRecording, markers: Planar, begin: float) -> Planar:
    """Mean of markers, (T, M), over a reference period that ends just before an event, (M,): the finger is at rest.

    Motion capture may need a moment to settle: by a tenth of a degree in the first 0.2 s of the recorded segment.
    """
    end = begin - _EVENT_MARGIN
    span = (recording.time > end - recording.config.reference) & (recording.time <= end)
    return np.nanmean(markers[span if span.any() else recording.time < begin], axis=0)


def _check_constant(recording: HardwareRecording, opens: float, closes: float) -> None:
    """Checks that pressures, if they were measured, are constant from a third of the time of an open valve on."""
    if recording.pressures is None:
        return
    begin = opens + (closes - opens) / 3
    open_pressures = recording.pressures[(recording.time > begin) & (recording.time < closes - _EVENT_MARGIN)]
    open_pressures = open_pressures[np.isfinite(open_pressures).all(axis=1)]
    span = np.ptp(open_pressures, axis=0) if len(open_pressures) else np.zeros(1)
    if span.max() > _MAX_PRESSURE_VARIATION * np.abs(open_pressures).max(initial=0.0):
        min_kpa, max_kpa = (1e-3 * extreme(open_pressures[:, span.argmax()]) for extreme in (np.min, np.max))
        changes = f"{min_kpa:.3g} to {max_kpa:.3g} kPa from {begin:.2f} to {closes:.2f} s"
        expected = "one constant pressure is read, that of the file's name: write a file for each,"
        expected += " with a rest before it"
        raise InputError(recording.name, "pressures", changes, expected)


def _valve_closing(recording: HardwareRecording, shift: Array) -> float:
    """Time at which the finger starts to move back, s."""
    time, row = recording.time, int(np.flatnonzero(shift > _EVENT_SHARE * np.nanmax(shift))[-1])
    if row >= len(shift) - 2:
        raise InputError(recording.name, "event", "step", "the valve does not close before the recording ends")
    open_shift = np.nanmean(shift[(time > time[row] - 2 * SETTLED_TIME) & (time < time[row] - SETTLED_TIME)])
    while row > 0 and not shift[row] > _CLOSING_SHARE * open_shift:
        row -= 1
    return float(time[row])


def _motion_begin(recording: HardwareRecording, shift: Array) -> float:
    is_reference = recording.time < recording.time[0] + recording.config.reference
    if not np.nanmax(shift) > 5 * np.nanmax(shift[is_reference]):
        expected = "the tip hardly moves more than before the event; is this the right description of the file?"
        raise InputError(recording.name, "markers", f"{1e3 * np.nanmax(shift):.2g} mm", expected)
    row = int(np.flatnonzero(shift > _EVENT_SHARE * np.nanmax(shift))[0])
    while row > 0 and not shift[row] < _ONSET_SHARE * np.nanmax(shift):
        row -= 1
    return float(recording.time[row])


def marker_rotation(markers: Planar, reference: Planar) -> Array:
    """Rotation of markers from the reference in the bending plane, (..., M) -> (...) rad.

    The angle of the rotation that aligns the two best, by least squares.
    """
    centred = markers - markers.mean(axis=-1, keepdims=True)
    angle: Array = np.angle(np.vecdot(reference - reference.mean(), centred))
    return angle


def settled_mean(time: Array, values: NDArray[Any], end: float) -> Any:
    """Mean of values (T, ...) over the last moments before `end`, s."""
    return np.nanmean(values[(time > end - SETTLED_TIME) & (time <= end)], axis=0)


_TIME_STEP = 2e-3  # s; an eighth of it changes the frequency of the beam by 0.2 %, its decrement by 2 %
_STABLE_STEP_SHARE = 0.5  # of the longest stable time step
_LOG_PERIOD = 0.01  # s, of the log
_FILL_STEP = 2e-3  # s, time step of the pressure
_FILL_SUPPLY = 10e3  # Pa, at which the fill time is defined
_PRESSURE_LEVELS = 200  # of the pressure, between which the compliance of the chamber is interpolated
_MIN_RELEASE_TIME = 1e-3  # s
_ROOT_LINK = "root"


@dataclass(frozen=True)
class Setup:
    """Properties of the set-up of recordings, and not of the finger; saved beside its file."""

    mounting_x: float = quantity(0.0, "m")  # of the neutral axis in B at the base
    mounting_z: float = quantity(0.0, "m")  # of the base in B
    mounting_angle: float = quantity(0.0, "rad")  # of the straight finger in B, from z toward x
    held_pose: bool = False  # whether the pose in which a hand holds the tip is fitted to every recording
    load_x: float = quantity(0.0, "m")  # of a load from its stated position, in the tip's frame
    load_z: float = quantity(0.0, "m")  # of a load from its stated position
    load_friction: float = quantity(0.0, "m", least=0)  # torque of friction at the hook of a load, over its weight
    marker_mass: float = quantity(0.0, "kg", least=0)  # of the markers on the tip, all together
    # Time in which a chamber that does not swell fills from a supply of 10 kPa
    fill_time: float = quantity(0.06, "s", above=0)
    swelling: float = quantity(1.0, least=0)  # growth of the chamber's compliance per growth of the bend per pressure
    # Pressure that the supply lacks when the valve opens, and the time in which that decays by 63 %
    supply_lag: float = quantity(0.0, "Pa", least=0)
    supply_time: float = quantity(1.0, "s", above=0)
    dry_friction: float = quantity(0.0, "rad", least=0)  # by which the whole finger lags behind its balance at most
    backlash: float = quantity(0.0, "m", least=0)  # by which pulled lengths lag behind what is wound at most
    delay: float = quantity(0.0, "s")  # by which settled states come after the pulled lengths that they belong to
    highest_pressure: float = quantity(0.0, "Pa", least=0)  # of the recordings that were fitted; 0: none
    heaviest_load: float = quantity(0.0, "kg", least=0)  # of the recordings that were fitted; 0: none


@dataclass(frozen=True)
class TipMotion:
    """The tip of a finger, in the frame of its mounting."""

    time: Array  # (T,) s, since the event
    tip: Planar  # (T,) m
    heading: Array  # (T,) rad


def simulated_markers(finger: Finger, setup: Setup, motion: MeasuredMotion) -> Planar:
    """Simulated positions of the markers of a recording, (T, M) m in B, at the times of the recording.

    Raises:
        SimulationDivergedError: if the chain does not stay finite.
    """
    mount, angle = planar_vector(setup.mounting_x, setup.mounting_z), setup.mounting_angle
    tip = tip_motion(finger, setup, motion)
    tip_offsets = rotated(rotated(motion.reference - mount, -angle) - tip.tip[0], -tip.heading[0])
    markers = mount + rotated(tip.tip[:, None] + rotated(tip_offsets, tip.heading[:, None]), angle)
    time = motion.time - motion.events[0]
    return np.array([np.interp(time, tip.time, marker) for marker in markers.T]).T


def tip_motion(finger: Finger, setup: Setup, motion: MeasuredMotion) -> TipMotion:
    """Simulates a finger from the first event on, at rest before it: straight, or as a hand holds it."""
    loaded = replace(finger, tip_load=_tip_load(finger, setup, motion))
    duration = float(motion.time[-1] - motion.events[0]) + _LOG_PERIOD
    step = min(_TIME_STEP, _STABLE_STEP_SHARE * loaded.stable_time_step())
    step = _LOG_PERIOD / np.ceil(_LOG_PERIOD / step)  # so that the log falls on steps
    builder = DiagramBuilder()
    gravity = RotationMatrix.MakeYRotation(-setup.mounting_angle) @ motion.gravity
    load = _hanging_load(setup, motion)
    hung_load = HungLoad(load, motion.string, setup.load_friction) if load and motion.string else None
    plant_finger = _add_finger(builder, loaded, gravity, step, hung_load)
    pressure = motion.pressure or 0.0
    limits = PressureConfig(minimum=min(pressure, 0.0), maximum=max(pressure, 1.0), time_constant=0.0)
    command = add_pressure_drive(builder, [plant_finger], limits).commands[plant_finger.name]
    held_pose = _held_pose(plant_finger, motion.hold)
    chamber_source = builder.AddSystem(TrajectorySource(_chamber_pressure(finger, setup, motion, duration)))
    builder.Connect(chamber_source.get_output_port(), command)
    if motion.pressure is None:
        hand = builder.AddSystem(TrajectorySource(_hand_force(held_pose.force, motion)))
        builder.Connect(hand.get_output_port(), plant_finger.plant.get_applied_generalized_force_input_port())
    log = LogVectorOutput(plant_finger.plant.get_state_output_port(), builder, _LOG_PERIOD)
    simulator = Simulator(builder.Build())
    _set_state(plant_finger, held_pose, simulator)
    try:
        simulator.AdvanceTo(duration)
    except RuntimeError as error:
        raise SimulationDivergedError(f"{motion.name}: {error}") from None
    data = log.FindLog(simulator.get_context())
    q = (plant_finger.position_selector() @ data.data()).T
    shear = (plant_finger.position_selector("shear") @ data.data()).T if finger.shear_factor > 0 else None
    chain = forward_kinematics(q, finger.segment_length, shear)
    if not np.isfinite(q).all():
        raise SimulationDivergedError(f"{motion.name}: joint angles are not finite")
    return TipMotion(data.sample_times(), chain.tip, chain.headings[:, -1])


def _add_finger(
    builder: DiagramBuilder, finger: Finger, gravity: Array, time_step: float, hung_load: HungLoad | None
) -> PlantFinger:
    """Adds a plant of a single finger with a fixed base, a load that swings at its tip, and no contact geometry."""
    robot = ET.Element("robot", name="identified")
    robot.append(ET.Element("link", name=_ROOT_LINK))
    robot.extend(finger_to_urdf(FingerElement(finger, _ROOT_LINK), visuals=False))
    for link in robot.findall("link"):
        for skin in link.findall("collision"):
            link.remove(skin)
    plant = builder.AddNamedSystem("plant", MultibodyPlant(time_step))
    (model,) = Parser(plant).AddModelsFromString(ET.tostring(robot, encoding="unicode"), "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(_ROOT_LINK))
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    if hung_load is not None:
        hung_load.add_to(plant, plant.GetFrameByName(tip_name(finger.name), model), gravity)
    plant.Finalize()
    if hung_load is not None:
        hung_load.connect(builder, plant)
    return PlantFinger(finger, plant, model)


class _HeldPose(NamedTuple):
    """Force of a hand that holds a finger's tip, and the pose."""

    force: Array  # (nv) generalized
    positions: Array  # (nv) of the joints


def _held_pose(finger: PlantFinger, hold: Hold | None) -> _HeldPose:
    """Pose before a release: straight without a hold; else with the tip in a hand and creep at its end.

    Angles are small: the joints yield to weight, and to a force and a moment of the hand, by their stiffness less all
    creep. Force and moment bring the tip to its position and direction.
    """
    plant, context = finger.plant, finger.plant.CreateDefaultContext()
    weight = plant.CalcGravityGeneralizedForces(context)
    if hold is None:
        return _HeldPose(-weight, 0 * weight)
    stiffness, remaining_share = np.full(plant.num_velocities(), np.inf), 1 - shares(finger.finger).sum()
    for deformation, joint_stiffness in finger.finger.stiffnesses.items():
        starts = [joint.velocity_start() for joint in finger.joints_of(deformation)]
        stiffness[starts] = joint_stiffness * (remaining_share if deformation == "bending" else 1.0)
    world, velocity = plant.world_frame(), JacobianWrtVariable.kV
    jacobian = plant.CalcJacobianSpatialVelocity(context, velocity, finger.frames[-1], np.zeros(3), world, world)
    tip_jacobian = jacobian[[3, 1]]  # its velocity along x, and its turn about y
    gap = (hold.sag, hold.turn) - tip_jacobian @ (weight / stiffness)
    hand_force = np.linalg.solve(tip_jacobian @ (tip_jacobian / stiffness).T, gap) @ tip_jacobian
    is_swinging = np.isinf(stiffness)  # a load that hangs down, wherever the tip turns
    return _HeldPose(hand_force, np.where(is_swinging, -hold.turn, (weight + hand_force) / stiffness))


def _set_state(finger: PlantFinger, pose: _HeldPose, simulator: Simulator) -> None:
    """Sets the initial state of a simulation."""
    diagram, context = simulator.get_system(), simulator.get_mutable_context()
    plant_context = finger.plant.GetMyMutableContextFromRoot(context)
    finger.plant.SetPositions(plant_context, pose.positions)
    if finger.finger.creep and pose.positions.any():
        name = f"{finger.name}.creep"
        creep = diagram.GetSubsystemByName(name)
        q = pose.positions[[joint.velocity_start() for joint in finger.joints]]
        z = np.tile(q, (len(finger.finger.creep), 1))
        creep.set_internal_angles(creep.GetMyMutableContextFromRoot(context), z, q)


def _tip_load(finger: Finger, setup: Setup, motion: MeasuredMotion) -> TipLoad | None:
    """Masses fixed to the tip, a load that does not swing and the markers, as one mass in their centre."""
    loads = [finger.tip_load, None if motion.string else _hanging_load(setup, motion)]
    point_masses = [(load.mass, load.x, load.z) for load in loads if load is not None]
    if setup.marker_mass > SIZES[0]:
        mean_offset = complex(motion.reference.mean()) - finger.length
        point_masses.append((setup.marker_mass, mean_offset.imag, mean_offset.real))
    if not point_masses:
        return None
    mass, x, z = np.transpose(point_masses)
    return TipLoad(float(mass.sum()), *(float(mass @ place / mass.sum()) for place in (x, z)))


def _hanging_load(setup: Setup, motion: MeasuredMotion) -> TipLoad | None:
    """Load at the tip, at its fitted position."""
    load = motion.load
    return load and replace(load, x=load.x + setup.load_x, z=load.z + setup.load_z)


def _hand_force(force: Array, motion: MeasuredMotion) -> PiecewisePolynomial:
    """Generalized force of a hand during a release: decreases linearly to 0."""
    duration = max(motion.events[1] - motion.events[0], _MIN_RELEASE_TIME)
    return PiecewisePolynomial.FirstOrderHold([0.0, duration], np.column_stack([force, 0 * force]))


def _chamber_pressure(finger: Finger, setup: Setup, motion: MeasuredMotion, duration: float) -> PiecewisePolynomial:
    """Pressure in the chamber since the first event: it fills and, after the second, empties.

    Air enters a chamber of compliance C through a narrow passage, where the loss of pressure grows with the square of
    the flow:  C(p) dp/dt = k sqrt(supply - p) . A chamber that swells takes more air:
    C(p) = C(0) (1 + swelling (growth of the bend per pressure there / that of a small pressure - 1)) .
    The supply comes up to its pressure with a lag:  supply = p - min(p, supply_lag) exp(-t / supply_time) .
    """
    if motion.pressure is None:
        return PiecewisePolynomial(np.zeros((1, 1)))
    open_for = motion.events[1] - motion.events[0]
    open_times = np.linspace(0.0, open_for, max(int(open_for / _FILL_STEP), 1) + 1)
    closed_times = np.arange(1, int((duration - open_for) / _FILL_STEP) + 3) * _FILL_STEP
    levels = motion.pressure * np.linspace(0.0, 1.0, _PRESSURE_LEVELS + 1)[1:]
    law = finger.pressure_law
    slope = np.ones(_PRESSURE_LEVELS) if law is None else np.gradient(law.bend(levels), levels)
    compliance = 1 + setup.swelling * (slope / slope[0] - 1)
    rates = np.sqrt(_FILL_SUPPLY) / (setup.fill_time * compliance)  # sqrt(Pa)/s, at which sqrt(supply - p) falls
    first_lack = np.clip(motion.pressure, -setup.supply_lag, setup.supply_lag)
    supply = motion.pressure - first_lack * np.exp(-open_times[1:] / setup.supply_time)
    filling = _follow_supply(0.0, supply, np.diff(open_times), np.abs(levels), rates)
    emptying = _follow_supply(
        filling[-1], 0 * closed_times, np.full(len(closed_times), _FILL_STEP), np.abs(levels), rates
    )
    time = np.concatenate([open_times, open_for + closed_times])
    return PiecewisePolynomial.FirstOrderHold(time, np.concatenate([[0.0], filling, emptying])[None])


def _follow_supply(pressure: float, supplies: Array, steps: Array, levels: Array, rates: Array) -> list[float]:
    """Pressures, Pa, after time steps, s, that follow the supply at rates for levels of the pressure."""
    pressures = []
    for supply, step in zip(supplies.tolist(), steps.tolist(), strict=True):
        pressure_gap = supply - pressure
        root = max(np.sqrt(abs(pressure_gap)) - step * float(np.interp(abs(pressure), levels, rates)), 0.0)
        pressure = supply - np.copysign(root**2, pressure_gap)
        pressures.append(pressure)
    return pressures
