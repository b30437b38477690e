"""Single contacts as arrays, in a file."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cache
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZipFile

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray
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

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.diagrams.wiring.scoring import add_true_contact
from soft_gripper.errors import InputError, first_line, shortened
from soft_gripper.estimators.plane import BendingPlane
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import check_regular
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.model_files import add_fingers, model_path
from soft_gripper.scenario.schema import PressureConfig
from soft_gripper.truth.contact import touches

FINGER = "package://soft_gripper/grippers/finger.urdf"
G = 9.81  # m/s^2
PEG_LENGTH, MESH_EDGE = 0.06, 0.001  # m
PEG_FRICTION = 0.3  # Coulomb, of the peg's surface unless another is requested
MOST_FRICTION = 100.0  # Coulomb; with more, nothing slides
PERIOD = 0.01  # s, of the plant
PAUSE, PATIENCE, STILL = 0.5, 3.0, 1e-3  # s between checks, longest wait, s, and rate at rest, rad/s


@cache
def read_finger() -> Finger:
    """The finger of every bench."""
    (finger,) = expand_urdf(model_path(FINGER)).fingers
    return finger


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
        return self._settled(context)

    def _velocity(self, context: Context) -> float:
        return float(np.abs(self._plant.GetVelocities(context)).max())

    def _settled(self, context: Context) -> Settled:
        finger, of_plant = self._plant_finger, self._plant.GetMyContextFromRoot(context)
        q = finger.position_selector() @ self._plant.GetPositionsAndVelocities(of_plant)
        forces = self._plant.get_generalized_contact_forces_output_port(finger.model).Eval(of_plant)
        signals = ("link_contact_force", "true_contact_force", "true_contact_total", "true_contact_arc_length")
        link_force, *others = (self._read(signal, context) for signal in signals)
        torque = finger.torque_selector() @ forces
        return Settled(q, self._velocity(of_plant), torque, link_force, *(float(value[0]) for value in others))

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
    return complex(chain.at(np.array([s]), float(face) + SIDES[side] * radius).points[0])


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
    def gravity(self) -> complex:
        """In the bending plane, z + i x in B, m/s^2."""
        plane = BendingPlane(self.R_WB.matrix()[:, ::2].T, np.zeros(3))
        return complex(plane.planar(np.array([0.0, 0.0, -G])))


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
    q = resting_angles(finger, 1e3 * drawn.touching_kpa, drawn.gravity)
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


_LARGEST = 2**26  # bytes of all arrays of a file: 200 000 contacts


@dataclass(frozen=True, eq=False)
class Contacts:
    """Ground truth of M single contacts of one finger with N joints, at rest; see `TrueContact`."""

    q: Array  # (M, N) rad, joint angles
    pressure: Array  # (M,) Pa
    gravity: Planar  # (M,) m/s^2, in the bending plane, z + i x in B
    force: Array  # (M,) N, across the finger, positive on the inner side
    total: Array  # (M,) N, friction included
    arc_length: Array  # (M,) m, from the base
    torque: Array  # (M, N) N m, true external torque
    side: NDArray[np.str_]  # (M,) "inner" or "outer"
    radius: Array  # (M,) m, of the peg
    friction: Array  # (M,) Coulomb, between finger and peg

    def at(self, rows: NDArray[np.int_]) -> "Contacts":
        """Some of the contacts, by their numbers."""
        return Contacts(*(getattr(self, each.name)[rows] for each in fields(self)))

    @property
    def finger(self) -> Finger:
        """The finger that was pressed, the same in all."""
        return read_finger()


class _Kind(NamedTuple):
    """The valid range of an array of a file; of the absolute value for signed and complex numbers."""

    type: type
    least: float = 0.0
    most: float = 0.0
    signed: bool = False
    of_joints: bool = False

    def can_be(self, values: NDArray[Any]) -> NDArray[np.bool_]:
        """Which of the values are in the range; NaN and infinity are not."""
        if self.type is str:
            return np.isin(values, list(SIDES))
        sizes = np.abs(values) if self.signed else values
        inside: NDArray[np.bool_] = (self.least <= sizes) & (sizes <= self.most)
        return inside

    @property
    def range(self) -> str:
        """In words."""
        if self.type is str:
            return " or ".join(SIDES)
        return f"numbers of {self.least:g} to {self.most:g}" + (" in size" if self.signed else "")


_ARRAYS = {
    "q": _Kind(float, 0, math.pi, signed=True, of_joints=True),
    "pressure": _Kind(float, 0, 1e6, signed=True),
    "gravity": _Kind(complex, 0, 100, signed=True),
    "force": _Kind(float, 1e-3, 1e3, signed=True),  # errors are shares of it
    "total": _Kind(float, 1e-3, 1e3),
    "arc_length": _Kind(float, 0, 1),
    "torque": _Kind(float, 0, 100, signed=True, of_joints=True),
    "side": _Kind(str),
    "radius": _Kind(float, 1e-4, 1),
    "friction": _Kind(float, 0, MOST_FRICTION),
}


def as_arrays(contacts: Sequence[Contact]) -> Contacts:
    """Contacts one after the other."""
    drawn, found = [contact.drawn for contact in contacts], [contact.found for contact in contacts]
    of_found = {name: np.array([getattr(each, name) for each in found]) for name in ("q", "force", "total", "torque")}
    return Contacts(
        pressure=1e3 * np.array([each.pressure_kpa for each in drawn]),
        gravity=np.array([each.gravity for each in drawn]),
        arc_length=np.array([each.arc_length for each in found]),
        side=np.array([each.side for each in drawn]),
        radius=1e-3 * np.array([each.radius_mm for each in drawn]),
        friction=np.array([contact.friction for contact in contacts]),
        **of_found,
    )


def save_contacts(contacts: Contacts, path: Path) -> None:
    """Writes a file (.npz) with an array for every field."""
    arrays = {field.name: getattr(contacts, field.name) for field in fields(contacts)}
    with atomic_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, **arrays)


def load_contacts(path: Path | str) -> Contacts:
    """Reads what `save_contacts` wrote; sizes and shapes are checked before anything is decompressed.

    Raises:
        InputError: naming the array, if one is missing, damaged, or has values that are impossible for this finger.
    """
    check_regular(Path(path))
    try:
        with ZipFile(path) as archive:
            _check_members(path, archive)
            arrays = {name: _read_array(path, name, archive.read(f"{name}.npy")) for name in _ARRAYS}
    except InputError:
        raise
    except Exception as error:  # from parsers that do not document what they raise
        expected = f"is damaged, or was not written by `contact-trials`: {shortened(first_line(error), 100)}"
        raise InputError("contacts", "file", str(path), expected) from None
    for name, values in arrays.items():
        if len(values) != len(arrays["q"]):
            raise InputError(path, name, len(values), f"give as many contacts as in q, {len(arrays['q'])}")
    return Contacts(**arrays)


def _check_members(path: Path | str, archive: ZipFile) -> None:
    """Checks the directory of the archive."""
    members = archive.infolist()
    found, expected = Counter(member.filename for member in members), Counter(f"{name}.npy" for name in _ARRAYS)
    if found != expected:
        (odd, *_) = (found - expected) or (expected - found)
        raise InputError(path, "arrays", odd, f"the file must hold each of these once: {', '.join(_ARRAYS)}")
    size = sum(member.file_size for member in members)
    if size > _LARGEST:
        raise InputError(path, "size", size, f"give arrays of at most {_LARGEST} bytes in all")


def _read_array(path: Path | str, name: str, content: bytes) -> NDArray[Any]:
    """The array of a member of the archive, which fills the shape in its header."""
    file, kind = BytesIO(content), _ARRAYS[name]
    npy.read_magic(file)
    shape, _, dtype = npy.read_array_header_1_0(file)
    joints = (read_finger().segments,) if kind.of_joints else ()
    if np.dtype(kind.type).kind != dtype.kind:
        raise InputError(path, name, str(dtype), f"give an array of {np.dtype(kind.type)}")
    if shape[1:] != joints or len(shape) != 1 + len(joints) or shape[0] < 1:
        raise InputError(
            path, name, shape, f"give an array of shape {('contacts', *joints)}, with at least one contact"
        )
    if math.prod(shape) * dtype.itemsize != len(content) - file.tell():
        raise InputError(path, name, shape, f"does not fit the {len(content) - file.tell()} bytes of the array")
    values: Array = np.asarray(npy.read_array(BytesIO(content), allow_pickle=False), kind.type)
    wrong = values[~kind.can_be(values)]
    if len(wrong):
        raise InputError(path, name, wrong[0].item(), f"give {kind.range}")
    return values
