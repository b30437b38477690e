"""Simulates grasps that leave the plane of the fingers, with planar and with spatial fingers.

Fingers close on an object by 100 kPa, lift it by 50 mm, and hold it while it is pushed sideways with half a newton.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from pydrake.common.schema import Transform
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    CalcContactFrictionFromSurfaceProperties,
    ExternallyAppliedSpatialForce,
    MultibodyPlant,
)
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import Context, DiagramBuilder, LeafSystem
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scene import Scene, add_plant, first_body
from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import ModelConfig, Scenario

PRESSURE = 100e3  # Pa
CLOSED_TIME, LIFTED_TIME, PUSH_TIME, END = 2.0, 3.5, 4.5, 5.5  # s
LIFT_HEIGHT = 0.05  # m
PUSH_FORCE = 0.5  # N, at the centre of the object, along y: across the plane of two fingers
SPATIAL = "bending sideways twist"
_LIFT = ModelConfig(name="lift", file=str(Path(__file__).with_name("lift.urdf")), child="rail")
_ROLLED = (np.pi / 2, 0.0, 0.0)  # rad, of a cylinder whose axis lies along y


@dataclass(frozen=True)
class TurnedGrasp:
    """A shipped scenario whose object stands elsewhere: turned about the vertical, degrees, and shifted along y, m."""

    scenario: str
    turn: float = 0.0
    shift: float = 0.0
    height: float = 0.03001  # m
    object: ModelConfig | None = None  # another one


_CYLINDER = ModelConfig("cylinder", "package://soft_gripper/objects/cylinder.obj", free=True)
_CYLINDER.mass, _CYLINDER.friction = 0.05, 0.8
GRASPS = {
    "box": TurnedGrasp("box_grasp"),
    "box, 15 mm off the plane": TurnedGrasp("box_grasp", shift=0.015),
    "box, turned by 20 degrees": TurnedGrasp("box_grasp", turn=20.0),
    "cylinder on its side, turned by 30 degrees": TurnedGrasp("box_grasp", turn=30.0, height=0.02301, object=_CYLINDER),
    "apple, three fingers": TurnedGrasp("three_finger_grasp", height=0.02742),
}


class GraspOutcome(NamedTuple):
    """Final state of an object; angles in degrees, forces in N, lengths in mm."""

    on_table: float  # turn about the vertical when the fingers have closed
    lifted: float  # and when it is held in the air
    tilt: float  # of its vertical axis, in the air
    force: float  # of a finger across the surface that it touches, mean
    sideways: float  # of the tips out of their planes, the largest
    twist: float  # of the fingers, the largest
    friction: float  # of a patch over the friction that it can bear, the largest while the object is held
    compliance: float  # mm/N, of the held object under the push


class GraspRun(NamedTuple):
    """A grasp that was simulated."""

    scenario: Scenario
    recording: Recording  # of the plant's state
    outcome: GraspOutcome


def grasp_scenario(grasp: TurnedGrasp, yields: str) -> Scenario:
    """Scenario of a grasp, whose gripper hangs on a lift."""
    scenario = load_scenario(grasp.scenario, [f"models.gripper.fingers.all.yields={yields}"])
    gripper, table, body = scenario.models
    R_roll = RollPitchYaw(*_ROLLED).ToRotationMatrix() if grasp.object else RotationMatrix()
    R_turn = RotationMatrix.MakeZRotation(np.radians(grasp.turn)) @ R_roll
    place = Transform(RigidTransform(R_turn, [0.0, grasp.shift, grasp.height]))
    gripper.parent = "lift::carriage"
    scenario.models = [_LIFT, gripper, table, replace(grasp.object or body, X_PC=place)]
    return scenario


class _Push(LeafSystem):
    """A force on the centre of a body, from PUSH_TIME on."""

    def __init__(self, plant: MultibodyPlant, model: str):
        super().__init__()
        body = first_body(plant, model)
        self._force = ExternallyAppliedSpatialForce()
        self._force.body_index = body.index()
        self._force.p_BoBq_B = body.CalcCenterOfMassInBodyFrame(plant.CreateDefaultContext())
        self.DeclareAbstractOutputPort("forces", lambda: Value([ExternallyAppliedSpatialForce()]), self._calc)

    def _calc(self, context: Context, output: AbstractValue) -> None:
        # The force grows over a tenth of a second, so that the object does not swing.
        share = np.clip((context.get_time() - PUSH_TIME) / 0.1, 0.0, 1.0)
        self._force.F_Bq_W = SpatialForce(np.zeros(3), np.array([0.0, PUSH_FORCE * share, 0.0]))
        output.set_value([self._force])


def run(grasp: TurnedGrasp, yields: str) -> GraspRun:
    """Simulates a grasp."""
    scenario, builder = grasp_scenario(grasp, yields), DiagramBuilder()
    scene = add_plant(builder, scenario)
    plant, thing = scene.plant, scenario.models[-1].name
    drive = add_pressure_drive(builder, scene.fingers, scenario.pressure)
    for command in drive.commands.values():
        builder.Connect(builder.AddSystem(ConstantVectorSource([PRESSURE])).get_output_port(), command)
    knots = np.array([[0.0, 0.0, LIFT_HEIGHT, LIFT_HEIGHT]])
    path = PiecewisePolynomial.CubicShapePreserving([0.0, CLOSED_TIME, LIFTED_TIME, END], knots, True)
    lift = builder.AddSystem(TrajectorySource(path, output_derivative_order=1))
    model = plant.GetModelInstanceByName("lift")
    builder.Connect(lift.get_output_port(), plant.get_desired_state_input_port(model))
    push = builder.AddSystem(_Push(plant, thing))
    builder.Connect(push.get_output_port(), plant.get_applied_spatial_force_input_port())
    simulator = Simulator(builder.Build())
    ApplySimulatorConfig(solver_config(scenario), simulator)
    context = plant.GetMyContextFromRoot(simulator.get_context())
    times, states, contacts = np.arange(0.0, END + 1e-9, 0.02), [], []
    for time in times:
        simulator.AdvanceTo(time)
        states.append(plant.GetPositionsAndVelocities(context))
        if LIFTED_TIME < time <= PUSH_TIME:
            contacts.append(_object_contacts(scene, context, thing))
    data = xr.Dataset({"plant.state": (("time", "state"), np.array(states))}, {"time": times})
    situations = [
        _situation(scene, thing, states[np.searchsorted(times, time)]) for time in (CLOSED_TIME, PUSH_TIME, END)
    ]
    return GraspRun(scenario, Recording(data), _outcome(situations, contacts, len(scene.fingers), bool(grasp.object)))


def _object_contacts(scene: Scene, context: Context, thing: str) -> Array:
    """Normal force of all patches on an object, N, and friction over the largest friction, (P, 2)."""
    inspector = scene.scene_graph.model_inspector()
    results = scene.plant.get_contact_results_output_port().Eval(context)
    object_geometries = set(scene.plant.GetCollisionGeometriesForBody(first_body(scene.plant, thing)))
    contacts = []
    for info in map(results.hydroelastic_contact_info, range(results.num_hydroelastic_contacts())):
        surface, force = info.contact_surface(), info.F_Ac_W().translational()
        pair = {surface.id_M(), surface.id_N()}
        if object_geometries & pair:
            normal = sum(surface.area(face) * surface.face_normal(face) for face in range(surface.num_faces()))
            normal_force = abs(force @ normal) / np.linalg.norm(normal)
            skins = [
                inspector.GetProximityProperties(skin).GetProperty("material", "coulomb_friction") for skin in pair
            ]
            bearable = CalcContactFrictionFromSurfaceProperties(*skins).static_friction() * normal_force
            contacts.append((normal_force, np.sqrt(max(force @ force - normal_force**2, 0.0)) / bearable))
    return np.array(contacts).reshape(-1, 2)


class _Situation(NamedTuple):
    """Poses at one time."""

    X_WO: RigidTransform  # of the object
    tips: Array  # (fingers, 3) m, each in its frame B
    twists: Array  # (fingers,) rad, in all


def _situation(scene: Scene, thing: str, state: Array) -> _Situation:
    plant, context = scene.plant, scene.plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state)
    tips = [f.frames[-1].CalcPose(context, f.base.body_frame()).translation() for f in scene.fingers]
    twisting = [f.joints_of("twist") if "twist" in f.finger.yields else [] for f in scene.fingers]
    twists = [sum(joint.get_angle(context) for joint in joints) for joints in twisting]
    return _Situation(plant.EvalBodyPoseInWorld(context, first_body(plant, thing)), np.array(tips), np.array(twists))


def _outcome(
    situations: Sequence[_Situation], contacts: Sequence[Array], fingers: int, is_rolled: bool
) -> GraspOutcome:
    closed_state, lifted_state, pushed_state = situations
    initial = RollPitchYaw(*_ROLLED).ToRotationMatrix() if is_rolled else RotationMatrix()
    turns = [(situation.X_WO.rotation() @ initial.inverse()).matrix() for situation in (closed_state, lifted_state)]
    on_table, in_air = (float(np.degrees(np.arctan2(turn[1, 0], turn[0, 0]))) for turn in turns)
    shift = 1e3 * (pushed_state.X_WO.translation() - lifted_state.X_WO.translation())
    return GraspOutcome(
        on_table,
        in_air,
        float(np.degrees(np.arccos(np.clip(turns[1][2, 2], -1, 1)))),
        float(np.mean([patches[:, 0].sum() for patches in contacts])) / fingers,
        float(1e3 * np.abs(lifted_state.tips[:, 1]).max()),
        float(np.degrees(np.abs(lifted_state.twists).max())),
        float(max(patches[:, 1].max(initial=0.0) for patches in contacts)),
        float(shift[1]) / PUSH_FORCE,
    )
