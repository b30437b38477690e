"""Random contacts of a finger with a peg, simulated: it rests against the peg, and is pressed until it rests again."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import AddContactMaterial, AddRigidHydroelasticProperties, Cylinder, ProximityProperties
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    CalcContactFrictionFromSurfaceProperties,
    CoulombFriction,
    MultibodyPlant,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import FixedOffsetFrame, RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.loaded_model import add_fingers
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.diagrams.wiring.scoring import add_true_contact
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar, forward_kinematics, in_space
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.runs.study import results
from soft_gripper.scenario.schema import PressureConfig
from soft_gripper.truth.contact import touches
from studies.contacts.contacts import FINGER, INNER, OUTER, Contacts, G, read_finger

PEG_LENGTH, MESH_EDGE = 0.06, 0.001  # m
PEG_FRICTION = 0.3  # Coulomb, of the peg's surface unless another is requested
PERIOD = 0.01  # s, of the plant
PAUSE, PATIENCE, STILL = 0.5, 3.0, 1e-3  # s between checks, longest wait, s, and rate at rest, rad/s


def combined_friction(friction: float) -> float:
    """Coulomb coefficient between the finger and a peg of that coefficient, 2 a b / (a + b) as Drake combines them."""
    of_finger, of_peg = (CoulombFriction(mu, mu) for mu in (read_finger().contact.friction, friction))
    return float(CalcContactFrictionFromSurfaceProperties(of_finger, of_peg).static_friction())


class Setting(NamedTuple):
    """How a contact is set up."""

    R_WB: RotationMatrix  # of the finger's base; gravity pulls along -z of the world
    center: complex  # m, of the peg, z + i x in B
    q: Array  # (N,) rad, where the finger begins
    pressure: float  # Pa


class Settled(NamedTuple):
    """The finger and its contact, once it rests; see `TrueContact`."""

    q: Array  # (N,) rad
    velocity: float  # rad/s, the largest of the joints
    torque: Array  # (N,) N m, true external torque
    link_force: Array  # (N + 1,) N
    force: float  # N
    total: float  # N
    arc_length: float  # m
    vector: Array  # (3,) N in B, friction included


class ContactBench:
    """One finger and one peg of a given radius along its bending axis."""

    def __init__(self, radius: float, friction: float):
        """`radius` of the peg, m, and the coefficient of friction of its surface."""
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=PERIOD, use_sampled_output_ports=False, stiction_tolerance=1e-5)
        plant, _ = AddMultibodyPlant(config, builder)
        (self._plant_finger,) = add_fingers(Parser(plant), FINGER)
        mount = plant.GetBodyByName("mount")
        peg = _add_peg(plant, radius, friction)
        self._base, self._peg = (_weld_to_movable_frame(plant, body) for body in (mount, peg))
        plant.Finalize()
        drive = add_pressure_drive(builder, [self._plant_finger], PressureConfig(time_constant=0.0))
        builder.ExportInput(drive.commands[self._plant_finger.name], "pressure")
        self._truth = add_true_contact(builder, [self._plant_finger])
        self._plant, self._diagram = plant, builder.Build()

    def press(self, setting: Setting) -> Settled:
        """Lets the finger press against the peg until it rests, or `PATIENCE` is over."""
        simulator = Simulator(self._diagram)
        context = simulator.get_mutable_context()
        self._diagram.GetInputPort("pressure").FixValue(context, setting.pressure)
        of_plant = self._plant.GetMyMutableContextFromRoot(context)
        X_WB = RigidTransform(setting.R_WB, [0, 0, 0])
        p_BPeg = in_space(np.array(setting.center))
        self._base.SetPoseInParentFrame(of_plant, X_WB)
        self._peg.SetPoseInParentFrame(of_plant, X_WB @ RigidTransform(p_BPeg))
        for joint, angle in zip(self._plant_finger.joints, setting.q, strict=True):
            joint.set_angle(of_plant, angle)
        simulator.Initialize()
        while context.get_time() < PATIENCE:
            simulator.AdvanceTo(context.get_time() + PAUSE)
            if self._velocity(of_plant) < STILL:
                break
        return self._settled(context, setting.R_WB)

    def _velocity(self, context: Context) -> float:
        return float(np.abs(self._plant.GetVelocities(context)).max())

    def _settled(self, context: Context, R_WB: RotationMatrix) -> Settled:
        finger, of_plant = self._plant_finger, self._plant.GetMyContextFromRoot(context)
        q = finger.position_selector() @ self._plant.GetPositionsAndVelocities(of_plant)
        forces = self._plant.get_generalized_contact_forces_output_port(finger.model).Eval(of_plant)
        signals = ("link_contact_force", "true_contact_force", "true_contact_total", "true_contact_arc_length")
        link_force, *others = (self._read(signal, context) for signal in signals)
        torque, in_world = finger.torque_selector() @ forces, self._read("true_contact_force_world", context)
        force, total, place = (float(value[0]) for value in others)
        vector = R_WB.matrix().T @ in_world
        return Settled(q, self._velocity(of_plant), torque, link_force, force, total, place, vector)

    def _read(self, signal: str, context: Context) -> Array:
        port = self._truth[f"{self._plant_finger.name}.{signal}"]
        value: Array = port.Eval(port.get_system().GetMyContextFromRoot(context))
        return value


def _add_peg(plant: MultibodyPlant, radius: float, friction: float) -> RigidBody:
    """A peg along y, with a mass that has no effect."""
    inertia = SpatialInertia(1.0, [0, 0, 0], UnitInertia.SolidSphere(radius))
    peg = plant.AddRigidBody("peg", plant.AddModelInstance("peg"), inertia)
    properties = ProximityProperties()
    AddContactMaterial(dissipation=2.0, friction=CoulombFriction(friction, friction), properties=properties)
    AddRigidHydroelasticProperties(MESH_EDGE, properties)
    lying = RigidTransform(RollPitchYaw(np.pi / 2, 0, 0), [0, 0, 0])
    plant.RegisterCollisionGeometry(peg, lying, Cylinder(radius, PEG_LENGTH), "peg", properties)
    return peg


def _weld_to_movable_frame(plant: MultibodyPlant, body: RigidBody) -> FixedOffsetFrame:
    """Welds a body to a frame in the world whose pose belongs to the context."""
    frame = FixedOffsetFrame(f"{body.name()}_place", plant.world_frame(), RigidTransform())
    place = plant.AddFrame(frame)
    plant.WeldFrames(place, body.body_frame())
    return place


SIDES = {"inner": 1, "outer": -1}  # toward +x of B or away from it


def peg_center(finger: Finger, q: Array, s: float, side: str, radius: float) -> complex:
    """Centre, z + i x m in B, of a peg along y that touches the inner or the outer face at arc length `s` m."""
    chain = forward_kinematics(q, finger.segment_length)
    link = int(chain.link_at(np.array(s)))
    section = finger.section((finger.link_ends[link] + finger.link_ends[link + 1]) / 2)
    face = section.inner_face if side == "inner" else section.outer_face
    return complex(chain.sites(np.array([s]), float(face) + SIDES[side] * radius).points[0])


RADIUS = (3, 12)  # mm, rounded, so that a bench serves many contacts
PLACE = (0.4, 1.0)  # of the finger's length
# kPa, the range of pressures at which the finger would just touch the peg.
TOUCHING = {"inner": (0.0, 120.0), "outer": (-30.0, 120.0)}
PRESSING = {"inner": 150.0, "outer": -50.0}  # kPa, the furthest pressure that follows
LEAST_FORCE = 0.05  # N
MOST_LINKS = 3
EDGE = 1.003  # times the largest total force for the normal force and friction; a larger one is not on a face


@dataclass(frozen=True)
class RandomContact:
    """The random parameters of a contact."""

    side: str  # of the finger, "inner" or "outer"
    radius_mm: float  # of the peg
    place_mm: float  # arc length at which it is placed against the finger
    touching_kpa: float  # pressure at which the finger would just touch it
    pressure_kpa: float
    orientation: tuple[float, float, float, float]  # of the finger's base, a unit quaternion w, x, y, z

    @property
    def R_WB(self) -> RotationMatrix:  # noqa: N802
        return RotationMatrix(Quaternion(np.array(self.orientation)))

    @property
    def gravity(self) -> Array:
        """(3,) m/s^2 in B."""
        return np.asarray(self.R_WB.matrix().T @ [0.0, 0.0, -G])


@dataclass(frozen=True)
class Contact:
    """A single contact at rest."""

    number: int
    drawn: RandomContact
    found: Settled
    redrawn: tuple[str, ...]  # why earlier draws were not single contacts
    friction: float  # Coulomb, between the finger and the peg


def draw(rng: np.random.Generator, length: float, places: tuple[float, float] = PLACE) -> RandomContact:
    """The random parameters of a contact, uniformly distributed; `length` of the finger, m, `places` shares of it."""
    side = str(rng.choice(list(SIDES)))
    radius = int(rng.integers(*RADIUS, endpoint=True))
    place = 1e3 * length * rng.uniform(*places)
    touching = rng.uniform(*TOUCHING[side])
    pressure = touching + (PRESSING[side] - touching) * rng.uniform()
    quaternion = rng.normal(size=4)
    orientation = tuple(map(float, quaternion / np.linalg.norm(quaternion)))
    return RandomContact(side, float(radius), float(place), float(touching), float(pressure), orientation)  # type: ignore[arg-type]


def run_contact(seed: int, number: int, friction: float, places: tuple[float, float] = PLACE) -> Contact:
    """Simulates draws until one is a single contact; the result does not depend on other contacts.

    `friction` is the coefficient of the peg's surface, which combines with the finger's; the peg is placed within
    `places`, shares of the length.
    """
    combined = combined_friction(friction)
    redrawn: list[str] = []
    while True:
        rng = np.random.default_rng([seed, number, len(redrawn)])
        drawn = draw(rng, read_finger().length, places)
        found = press(drawn, friction)
        flaw = flaw_of(drawn, found, combined)
        if not flaw:
            return Contact(number, drawn, found, tuple(redrawn), combined)
        redrawn.append(flaw)


@cache
def bench(radius_mm: float, friction: float) -> ContactBench:
    """The bench for pegs of a radius and a surface, one per process: systems written in Python are not freed."""
    return ContactBench(1e-3 * radius_mm, friction)


def press(drawn: RandomContact, friction: float) -> Settled:
    """The contact at rest, with a peg of that coefficient of friction."""
    finger = read_finger()
    q = resting_angles(finger, 1e3 * drawn.touching_kpa, as_planar(drawn.gravity[::2]))
    center = peg_center(finger, q, 1e-3 * drawn.place_mm, drawn.side, 1e-3 * drawn.radius_mm)
    return bench(drawn.radius_mm, friction).press(Setting(drawn.R_WB, center, q, 1e3 * drawn.pressure_kpa))


def flaw_of(drawn: RandomContact, found: Settled, friction: float) -> str:
    """Why it is not a single contact that can be measured; empty if it is one. `friction` is that of the contact."""
    touching = np.flatnonzero(touches(found.link_force))
    if not len(touching):
        return "lost"
    if found.velocity > STILL:
        return "not at rest"
    if len(touching) > MOST_LINKS or touching[-1] - touching[0] >= len(touching):
        return "several places"
    if found.total > EDGE * np.hypot(1, friction) * abs(found.force):
        return "on an edge"
    if found.force * SIDES[drawn.side] < LEAST_FORCE:
        return "too weak"
    return ""


def as_arrays(contacts: Sequence[Contact]) -> Contacts:
    """Contacts one after the other."""
    drawn, found = [contact.drawn for contact in contacts], [contact.found for contact in contacts]
    return Contacts(
        read_finger(),
        q=np.array([each.q for each in found]),
        pressure=1e3 * np.array([each.pressure_kpa for each in drawn]),
        gravity=np.array([each.gravity for each in drawn]),
        normal_force=np.abs([each.force for each in found]),
        force=np.array([each.vector for each in found]),
        torque=np.array([each.torque for each in found]),
        arc_length=np.array([each.arc_length for each in found]),
        side=np.array([INNER if each.force > 0 else OUTER for each in found]),
        friction=np.array([contact.friction for contact in contacts]),
    )


@dataclass(frozen=True)
class ContactRow:
    """The draw for a contact, and its ground truth."""

    contact: int
    side: str
    radius_mm: float
    place_mm: float  # arc length at which the peg was placed against the finger
    arc_length_mm: float  # where it presses
    force_n: float  # across the finger, positive on the inner side
    total_n: float  # friction included
    pressure_kpa: float
    gravity_x: float  # m/s^2, in B
    gravity_z: float
    redrawn: int  # number of draws that were not single contacts


def contact_row(contact: Contact) -> ContactRow:
    """The row of a contact."""
    drawn, found = contact.drawn, contact.found
    gravity_x, _, gravity_z = drawn.gravity.tolist()
    return ContactRow(
        contact=contact.number,
        side=drawn.side,
        radius_mm=drawn.radius_mm,
        place_mm=drawn.place_mm,
        arc_length_mm=1e3 * found.arc_length,
        force_n=found.force,
        total_n=found.total,
        pressure_kpa=drawn.pressure_kpa,
        gravity_x=gravity_x,
        gravity_z=gravity_z,
        redrawn=len(contact.redrawn),
    )


def run_contacts(
    number: int,
    seed: int,
    executor: Executor,
    report: Callable[[], Any],
    friction: float = PEG_FRICTION,
    places: tuple[float, float] = PLACE,
) -> list[Contact]:
    """Simulates contacts 0 to `number` - 1 of a seed, see `run_contact`; `report` is called after each."""
    jobs = {i: (seed, i, friction, places) for i in range(number)}
    return list(results(executor, run_contact, jobs, lambda i: report()).values())
