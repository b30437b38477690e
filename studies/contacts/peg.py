"""Random contacts of a finger with a peg, simulated: it rests against the peg, and is pressed until it rests again.

In: a seed and the number of contacts. Out: `RestingContact`s, their arrays and rows. Another number that is drawn is a
field of `RandomContact` and a line of `draw_contact`.
"""

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
from soft_gripper.extras.sweeps.study import results
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar, forward_kinematics, in_space
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.schema import PressureConfig
from soft_gripper.truth.contact import touches
from studies.contacts.contacts import FINGER, INNER, OUTER, Contacts, G, read_finger

PEG_LENGTH, MESH_EDGE = 0.06, 0.001  # m
PEG_FRICTION = 0.3  # Coulomb, of the peg's surface unless another is requested
PERIOD = 0.01  # s, of the plant
PAUSE, PATIENCE, STILL = 0.5, 3.0, 1e-3  # s between checks, longest wait, s, and rate at rest, rad/s


def combined_friction(friction: float) -> float:
    """Coulomb coefficient between the finger and a peg of that coefficient, 2 a b / (a + b) as Drake combines them."""
    surfaces = (CoulombFriction(mu, mu) for mu in (read_finger().contact.friction, friction))
    return float(CalcContactFrictionFromSurfaceProperties(*surfaces).static_friction())


class SettledFinger(NamedTuple):
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

    def press(self, R_WB: RotationMatrix, center: complex, q: Array, pressure: float) -> SettledFinger:
        """Lets the finger press against the peg until it rests, or `PATIENCE` is over.

        Args:
            R_WB: rotation of the finger's base; gravity pulls along -z of the world.
            center: of the peg, z + i x m in B.
            q: angles at which the finger begins, (N,) rad.
            pressure: in the chamber, Pa.
        """
        simulator = Simulator(self._diagram)
        context = simulator.get_mutable_context()
        self._diagram.GetInputPort("pressure").FixValue(context, pressure)
        plant_context = self._plant.GetMyMutableContextFromRoot(context)
        X_WB = RigidTransform(R_WB, [0, 0, 0])
        p_BPeg = in_space(np.array(center))
        self._base.SetPoseInParentFrame(plant_context, X_WB)
        self._peg.SetPoseInParentFrame(plant_context, X_WB @ RigidTransform(p_BPeg))
        for joint, angle in zip(self._plant_finger.joints, q, strict=True):
            joint.set_angle(plant_context, angle)
        simulator.Initialize()
        while context.get_time() < PATIENCE:
            simulator.AdvanceTo(context.get_time() + PAUSE)
            if self._velocity(plant_context) < STILL:
                break
        return self._settled_finger(context, R_WB)

    def _velocity(self, context: Context) -> float:
        return float(np.abs(self._plant.GetVelocities(context)).max())

    def _settled_finger(self, context: Context, R_WB: RotationMatrix) -> SettledFinger:
        finger, plant_context = self._plant_finger, self._plant.GetMyContextFromRoot(context)
        q = finger.position_selector() @ self._plant.GetPositionsAndVelocities(plant_context)
        forces = self._plant.get_generalized_contact_forces_output_port(finger.model).Eval(plant_context)
        signals = ("link_contact_force", "true_contact_force", "true_contact_total", "true_contact_arc_length")
        link_force, *other_signals = (self._read(signal, context) for signal in signals)
        torque = finger.torque_selector() @ forces
        world_force = self._read("true_contact_force_world", context)
        force, total, arc_length = (float(value[0]) for value in other_signals)
        vector = R_WB.matrix().T @ world_force
        return SettledFinger(q, self._velocity(plant_context), torque, link_force, force, total, arc_length, vector)

    def _read(self, signal: str, context: Context) -> Array:
        port = self._truth[f"{self._plant_finger.name}.{signal}"]
        return port.Eval(port.get_system().GetMyContextFromRoot(context))


def _add_peg(plant: MultibodyPlant, radius: float, friction: float) -> RigidBody:
    """Adds a peg along y, with a mass that has no effect."""
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
    frame = plant.AddFrame(FixedOffsetFrame(f"{body.name()}_place", plant.world_frame(), RigidTransform()))
    plant.WeldFrames(frame, body.body_frame())
    return frame


SIDES = {"inner": 1, "outer": -1}  # toward +x of B or away from it


def peg_center(finger: Finger, q: Array, s: float, side: str, radius: float) -> complex:
    """Centre, z + i x m in B, of a peg along y that touches the inner or the outer face at arc length `s` m."""
    chain = forward_kinematics(q, finger.segment_length)
    link = int(chain.link_at(np.array(s)))
    section = finger.section((finger.link_ends[link] + finger.link_ends[link + 1]) / 2)
    face = section.inner_face if side == "inner" else section.outer_face
    return complex(chain.sites(np.array([s]), float(face) + SIDES[side] * radius).points[0])


RADIUS = (3, 12)  # mm, rounded, so that a bench serves many contacts
PLACE = (0.4, 1.0)  # fractions of the finger's length
# kPa, the range of pressures at which the finger would just touch the peg.
TOUCHING = {"inner": (0.0, 120.0), "outer": (-30.0, 120.0)}
PRESSING = {"inner": 150.0, "outer": -50.0}  # kPa, the furthest pressure that follows
MIN_FORCE = 0.05  # N
MAX_LINKS = 3
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
class RestingContact:
    """A single contact at rest."""

    number: int
    draw: RandomContact
    settled: SettledFinger
    flaws: tuple[str, ...]  # of earlier draws, which were not single contacts
    friction: float  # Coulomb, between the finger and the peg


def draw_contact(rng: np.random.Generator, length: float, places: tuple[float, float] = PLACE) -> RandomContact:
    """Draws a contact, uniformly distributed; `length` of the finger, m, `places` fractions of it."""
    side = str(rng.choice(list(SIDES)))
    radius = float(rng.integers(*RADIUS, endpoint=True))
    place = float(1e3 * length * rng.uniform(*places))
    touch_pressure = float(rng.uniform(*TOUCHING[side]))
    pressure = touch_pressure + (PRESSING[side] - touch_pressure) * rng.uniform()
    quaternion = rng.normal(size=4)
    w, x, y, z = (quaternion / np.linalg.norm(quaternion)).tolist()
    return RandomContact(side, radius, place, touch_pressure, float(pressure), (w, x, y, z))


def run_contact(seed: int, number: int, friction: float, places: tuple[float, float] = PLACE) -> RestingContact:
    """Simulates draws until one is a single contact; the result does not depend on other contacts.

    `friction` is the coefficient of the peg's surface, which combines with the finger's; the peg is placed within
    `places`, fractions of the length.
    """
    combined, flaws = combined_friction(friction), list[str]()
    while True:
        rng = np.random.default_rng([seed, number, len(flaws)])
        draw = draw_contact(rng, read_finger().length, places)
        settled_finger = press(draw, friction)
        flaw = contact_flaw(draw, settled_finger, combined)
        if not flaw:
            return RestingContact(number, draw, settled_finger, tuple(flaws), combined)
        flaws.append(flaw)


@cache
def bench(radius_mm: float, friction: float) -> ContactBench:
    """The bench for pegs of a radius and a surface, one per process: systems written in Python are not freed."""
    return ContactBench(1e-3 * radius_mm, friction)


def press(draw: RandomContact, friction: float) -> SettledFinger:
    """The contact at rest, with a peg of that coefficient of friction."""
    finger = read_finger()
    q = resting_angles(finger, 1e3 * draw.touching_kpa, as_planar(draw.gravity[::2]))
    center = peg_center(finger, q, 1e-3 * draw.place_mm, draw.side, 1e-3 * draw.radius_mm)
    return bench(draw.radius_mm, friction).press(draw.R_WB, center, q, 1e3 * draw.pressure_kpa)


def contact_flaw(draw: RandomContact, settled: SettledFinger, friction: float) -> str:
    """Reason against a draw as a single measurable contact, or nothing; `friction` of the contact."""
    touched_links = np.flatnonzero(touches(settled.link_force))
    if not len(touched_links):
        return "lost"
    if settled.velocity > STILL:
        return "not at rest"
    if len(touched_links) > MAX_LINKS or touched_links[-1] - touched_links[0] >= len(touched_links):
        return "several places"
    if settled.total > EDGE * np.hypot(1, friction) * abs(settled.force):
        return "on an edge"
    if settled.force * SIDES[draw.side] < MIN_FORCE:
        return "too weak"
    return ""


def contact_arrays(contacts: Sequence[RestingContact]) -> Contacts:
    """Contacts one after the other."""
    values = zip(*(contact.settled for contact in contacts), strict=True)
    columns = dict(zip(SettledFinger._fields, map(np.array, values), strict=True))
    return Contacts(
        read_finger(),
        q=columns["q"],
        pressure=1e3 * np.array([contact.draw.pressure_kpa for contact in contacts]),
        gravity=np.array([contact.draw.gravity for contact in contacts]),
        normal_force=np.abs(columns["force"]),
        force=columns["vector"],
        torque=columns["torque"],
        arc_length=columns["arc_length"],
        side=np.where(columns["force"] > 0, INNER, OUTER),
        friction=np.array([contact.friction for contact in contacts]),
    )


@dataclass(frozen=True)
class ContactTruthRow:
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


def contact_row(contact: RestingContact) -> ContactTruthRow:
    """Makes the table row of a contact."""
    draw, settled_finger = contact.draw, contact.settled
    gravity_x, _, gravity_z = draw.gravity.tolist()
    return ContactTruthRow(
        *(contact.number, draw.side, draw.radius_mm, draw.place_mm, 1e3 * settled_finger.arc_length),
        *(settled_finger.force, settled_finger.total, draw.pressure_kpa, gravity_x, gravity_z, len(contact.flaws)),
    )


def run_contacts(
    number: int,
    seed: int,
    executor: Executor,
    report: Callable[[], Any],
    friction: float = PEG_FRICTION,
    places: tuple[float, float] = PLACE,
) -> list[RestingContact]:
    """Simulates contacts 0 to `number` - 1 of a seed, see `run_contact`; `report` is called after each."""
    jobs = {i: (seed, i, friction, places) for i in range(number)}
    return list(results(executor, run_contact, jobs, lambda i: report()).values())
