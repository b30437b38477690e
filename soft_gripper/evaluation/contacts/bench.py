"""A bench for single contacts: one finger and one static peg, turned and placed anew for every contact."""

from functools import cache
from typing import NamedTuple

import numpy as np
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
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.diagrams.wiring.scoring import add_true_contact
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.scenario.model_files import add_fingers, model_path
from soft_gripper.scenario.scenario import PressureConfig

FINGER = "package://soft_gripper/grippers/finger.urdf"
G = 9.81  # m/s^2
PEG_LENGTH, MESH_EDGE = 0.06, 0.001  # m
PEG_FRICTION = 0.3  # Coulomb, of the peg's surface unless another is requested
MOST_FRICTION = 100.0  # Coulomb; beyond, nothing slides
PERIOD = 0.01  # s, of the plant
PAUSE, PATIENCE, STILL = 0.5, 3.0, 1e-3  # s, s, rad/s: how long it is waited, at most, and for what


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
        p_BPeg = [setting.center.imag, 0.0, setting.center.real]
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
    """A peg along y, of no account for its mass."""
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
