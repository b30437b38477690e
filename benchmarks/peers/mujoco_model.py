"""A task as a MuJoCo model: the expanded URDF, read by MuJoCo itself, with what URDF cannot express."""

import mujoco
import numpy as np
from pydrake.math import RigidTransform

from peers.bodies import Body, combined
from peers.task import Setting, Task
from soft_gripper.fingers import Finger
from soft_gripper.fingers.finger_links import joint_name, link_name
from soft_gripper.fingers.urdf import ExpandedUrdf
from soft_gripper.scenario.schema import ModelConfig

_ALL, _TABLE = 0xFFFF, 1 << 15  # bits of contact: 0 is a body's, a finger's each of those that follow


def make_model(task: Task, setting: Setting) -> mujoco.MjModel:
    """The model under the options of a setting.

    A chamber is a fixed tendon along the joints of its finger, weighted by the pressure gain of each, that an actuator
    with the lag of the supply pulls at: pressures in, torques out, nothing in Python.
    """
    spec = mujoco.MjSpec()
    _set_options(spec, task, setting)
    for number, (model, expanded) in enumerate(task.grippers):
        _add_gripper(spec, model, expanded, first_bit=1 + number * len(expanded.fingers))
        for finger in expanded.fingers:
            _add_chamber(spec, model, finger, task.scenario.pressure.time_constant)
    for body in task.bodies:
        _add_body(spec, task, body, setting)
    for geom in spec.geoms:
        _set_contact(geom, setting)
    return spec.compile()


def angles_of(model: mujoco.MjModel, task: Task) -> np.ndarray:
    """Where the joint angles lie in qpos, (F, N)."""
    owned = [(config.name, finger) for config, expanded in task.grippers for finger in expanded.fingers]
    return np.array(
        [[model.joint(f"{name}/{joint_name(f.name, i)}").qposadr[0] for i in range(f.segments)] for name, f in owned]
    )


def _set_options(spec: mujoco.MjSpec, task: Task, setting: Setting) -> None:
    option = spec.option
    option.gravity = task.scenario.gravity
    option.timestep = setting["step"]
    option.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{setting['integrator'].upper()}")
    option.cone = getattr(mujoco.mjtCone, f"mjCONE_{setting.get('cone', 'elliptic').upper()}")
    option.impratio = setting.get("impratio", 1)
    option.noslip_iterations = setting.get("noslip_iterations", 0)
    if "sdf_initpoints" in setting:
        option.sdf_initpoints, option.sdf_iterations = setting["sdf_initpoints"], setting["sdf_iterations"]
    if not task.bodies:
        option.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT


def _add_gripper(spec: mujoco.MjSpec, model: ModelConfig, expanded: ExpandedUrdf, first_bit: int) -> None:
    gripper = mujoco.MjSpec.from_string(expanded.text)
    for number, finger in enumerate(expanded.fingers):
        own = 1 << (first_bit + number)  # links of one finger overlap when it bends, which is not a contact
        for i in range(finger.segments):
            gripper.joint(joint_name(finger.name, i)).stiffness = [finger.stiffness[i], 0, 0]
        for i in range(finger.segments + 1):
            body = gripper.body(link_name(finger.name, i))
            for geom in body.geoms if body is not None else []:
                geom.contype, geom.conaffinity, geom.friction = own, _ALL & ~own, [0, 0, 0]
    frame = spec.worldbody.add_frame()
    _place(frame, model.X_PC.GetDeterministicValue())
    spec.attach(gripper, frame=frame, prefix=f"{model.name}/")


def _add_chamber(spec: mujoco.MjSpec, model: ModelConfig, finger: Finger, lag: float) -> None:
    chamber = spec.add_tendon(name=f"{finger.name}_chamber")
    for i, gain in enumerate(finger.pressure_gain):
        chamber.wrap_joint(f"{model.name}/{joint_name(finger.name, i)}", gain)
    supply = spec.add_actuator(name=finger.name, target=chamber.name, trntype=mujoco.mjtTrn.mjTRN_TENDON)
    supply.dyntype, supply.dynprm[0], supply.gainprm[0] = mujoco.mjtDyn.mjDYN_FILTEREXACT, lag, 1.0


def _add_body(spec: mujoco.MjSpec, task: Task, body: Body, setting: Setting) -> None:
    """A body, with its friction against a finger; against a table, the friction of the table applies."""
    placed = spec.worldbody.add_body(name=body.name)
    _place(placed, body.X_WB)
    if body.free:
        placed.add_freejoint(name=body.name)
        placed.explicitinertial, placed.mass = True, body.mass
        placed.fullinertia = body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
    against_finger = combined(task.fingers[0].contact.friction, body.friction)
    if body.mesh is not None:
        surface = spec.add_mesh(name="surface", file=str(body.mesh))
        surface.octree_maxdepth = setting.get("octree_maxdepth", surface.octree_maxdepth)
    geom = placed.add_geom(friction=[against_finger, 0.005, 1e-4], conaffinity=_ALL)
    _place(geom, body.X_BG)
    _shape(geom, body)
    if body.mesh is not None:
        # A flat table touches a body where it touches its convex hull: exact, and fast.
        geom.conaffinity = _ALL & ~_TABLE
        foot = placed.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="surface", contype=0, conaffinity=_TABLE)
        _place(foot, body.X_BG)
    if task.free is not None and not body.free:
        geom.contype, geom.conaffinity = _TABLE, 0
        geom.priority, geom.friction[0] = 1, combined(task.free.friction, body.friction)


def _shape(geom: mujoco.MjsGeom, body: Body) -> None:
    if body.mesh is not None:
        geom.type, geom.meshname = mujoco.mjtGeom.mjGEOM_SDF, "surface"
    elif len(body.size) == 3:
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_BOX, np.array(body.size) / 2
    else:
        radius, length = body.size
        geom.type, geom.size = mujoco.mjtGeom.mjGEOM_CYLINDER, [radius, length / 2, 0]


def _set_contact(geom: mujoco.MjsGeom, setting: Setting) -> None:
    geom.condim = setting.get("condim", 3)
    if "solref" in setting:
        geom.solref = setting["solref"]
    if "solimp" in setting:
        geom.solimp = setting["solimp"]


def _place(placed: object, X: RigidTransform) -> None:
    placed.pos = X.translation()
    placed.quat = X.rotation().ToQuaternion().wxyz()
