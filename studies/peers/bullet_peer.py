"""The tasks in PyBullet: the expanded URDF, read by PyBullet itself, and the bodies around it."""

from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time
from typing import NamedTuple

import numpy as np
import pybullet
from pybullet_utils.bullet_client import BulletClient
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.fingers import Finger, forward_kinematics, gravity_torque
from soft_gripper.fingers.finger_links import joint_name
from soft_gripper.truth.contact import combined_friction
from studies.peers.bodies import Body
from studies.peers.sensing import sense
from studies.peers.task import PeerTask, PeerTrial, Run, Setting

_UNDAMPED = {"linearDamping": 0.0, "angularDamping": 0.0}


class BulletGripper(NamedTuple):
    """A model with fingers in PyBullet; the joints are those of the fingers, one after the other."""

    body: int
    fingers: tuple[Finger, ...]
    joints: list[int]


def add_scene(client: BulletClient, task: PeerTask, setting: Setting) -> tuple[list[BulletGripper], int | None]:
    """Adds the grippers and bodies of a task; returns the grippers and the id of the free body, or None."""
    grippers = [_add_gripper(client, task, i, setting) for i in range(len(task.grippers))]
    grasped = None
    for body in task.bodies:
        body_id = _add_body(client, task, body)
        grasped = body_id if body.is_free else grasped
    return grippers, grasped


def _add_gripper(client: BulletClient, task: PeerTask, gripper_index: int, setting: Setting) -> BulletGripper:
    model, expanded = task.grippers[gripper_index]
    X = model.X_PC.GetDeterministicValue()
    with TemporaryDirectory() as folder:
        path = Path(folder) / "gripper.urdf"
        path.write_text(expanded.text, encoding="utf-8")
        body = client.loadURDF(str(path), *_pose(X), useFixedBase=True)
    joint_numbers = {client.getJointInfo(body, i)[1].decode(): i for i in range(client.getNumJoints(body))}
    friction = _finger_friction(task)
    for joint in range(-1, client.getNumJoints(body)):
        client.changeDynamics(body, joint, lateralFriction=friction, **_UNDAMPED)
    joints = [joint_numbers[joint_name(finger.name, i)] for finger in expanded.fingers for i in range(finger.segments)]
    damping = [value for finger in expanded.fingers for value in finger.damping]
    for joint, value in zip(joints, damping, strict=True):
        # Every joint has a motor that holds it, unless it is disabled; implicit torques include the damping.
        client.setJointMotorControl2(body, joint, pybullet.VELOCITY_CONTROL, force=0)
        client.changeDynamics(body, joint, jointDamping=0.0 if setting["implicit"] else value)
    return BulletGripper(body, expanded.fingers, joints)


def _finger_friction(task: PeerTask) -> float:
    """PyBullet multiplies the frictions of two surfaces; this friction makes the product Drake's value."""
    touched_body = task.grasped_body or next(iter(task.bodies), None)
    if touched_body is None:
        return 0.0
    return combined_friction(task.fingers[0].contact.friction, touched_body.friction) / touched_body.friction


def _add_body(client: BulletClient, task: PeerTask, body: Body) -> int:
    position, turn = _pose(body.X_BG)
    body_id = client.createMultiBody(
        body.mass if body.is_free else 0.0,
        client.createCollisionShape(
            **_shape(client, body), collisionFramePosition=position, collisionFrameOrientation=turn
        ),
        -1,
        *_pose(body.X_WB),
    )
    friction = body.friction
    if task.grasped_body is not None and not body.is_free:
        friction = combined_friction(task.grasped_body.friction, body.friction) / task.grasped_body.friction
    client.changeDynamics(body_id, -1, lateralFriction=friction, **_UNDAMPED)
    if body.is_free:
        client.changeDynamics(body_id, -1, localInertiaDiagonal=body.inertia.diagonal().tolist())
    return body_id


def _shape(client: BulletClient, body: Body) -> dict[str, object]:
    """A moving body is convex in PyBullet, or made of convex parts."""
    if body.mesh is not None:
        return {"shapeType": pybullet.GEOM_MESH, "fileName": str(_convex_parts_file(client, body.mesh))}
    if len(body.size) == 3:
        return {"shapeType": pybullet.GEOM_BOX, "halfExtents": [edge / 2 for edge in body.size]}
    radius, length = body.size
    return {"shapeType": pybullet.GEOM_CYLINDER, "radius": radius, "height": length}


def _convex_parts_file(client: BulletClient, mesh: Path) -> Path:
    """File of the convex parts of a mesh by PyBullet's V-HACD, made once."""
    parts = Path("results/peers") / f"{mesh.stem}_parts.obj"
    if not parts.exists():
        parts.parent.mkdir(parents=True, exist_ok=True)
        client.vhacd(str(mesh), str(parts), str(parts.with_suffix(".log")))
    return parts


def _pose(X: RigidTransform) -> tuple[list[float], list[float]]:
    turn = X.rotation().ToQuaternion()
    return X.translation().tolist(), [turn.x(), turn.y(), turn.z(), turn.w()]


def make_run(task: PeerTask, setting: Setting) -> Run:
    """Makes runs by a client that is emptied before each.

    PyBullet has no joint springs. Python applies their torques at every step: explicitly, or so that the step of
    velocities is linearly implicit in springs and damping (`implicit`; stable PD, Tan et al. 2011).
    """
    client, substeps = BulletClient(pybullet.DIRECT), task.substeps(setting["step"])
    pressures = task.pressures(substeps)

    def run() -> PeerTrial:
        client.resetSimulation()
        client.setGravity(*task.scenario.gravity)
        client.setPhysicsEngineParameter(fixedTimeStep=setting["step"], **setting.get("engine", {}))
        grippers, grasped = add_scene(client, task, setting)
        springs = [_Springs(client, gripper, setting, -task.scenario.gravity[2]) for gripper in grippers]
        finger_indices = np.split(np.arange(len(task.fingers)), np.cumsum([len(g.fingers) for g in grippers])[:-1])
        angles = np.zeros((len(pressures), len(task.fingers), task.fingers[0].segments))
        objects = np.zeros((len(pressures), 0 if grasped is None else 3))
        start = process_time()
        for sample, period in enumerate(pressures):
            for pressure in period:
                for spring, indices in zip(springs, finger_indices, strict=True):
                    spring.apply(pressure[indices])
                client.stepSimulation()
            angles[sample] = np.concatenate([spring.state()[0] for spring in springs])
            if grasped is not None:
                objects[sample] = client.getBasePositionAndOrientation(grasped)[0]
        if task.sensed:
            sense(task, angles, pressures[:, -1])
        seconds = process_time() - start
        return PeerTrial(seconds, forward_kinematics(angles, task.fingers[0].segment_length).tip, objects)

    return run


class _Springs:
    """The torques at the joints of all fingers of one gripper, F of N joints."""

    def __init__(self, client: BulletClient, gripper: BulletGripper, setting: Setting, gravity: complex):
        self._client, self._gripper, self._gravity = client, gripper, gravity
        self._step, self._implicit = setting["step"], setting["implicit"]
        finger, fingers = gripper.fingers[0], len(gripper.fingers)
        self._finger, self._drag = finger, finger.damping + self._step * finger.stiffness
        self._metric = np.diag(np.tile(self._step * self._drag, fingers))

    def state(self) -> Array:
        """Angles and rates of the joints, (2, F, N)."""
        states = self._client.getJointStates(self._gripper.body, self._gripper.joints)
        return np.array([state[:2] for state in states]).T.reshape(2, len(self._gripper.fingers), -1)

    def apply(self, pressures: Array) -> None:
        """Applies the torques of the next step under pressures, (F,) Pa."""
        finger, (q, v) = self._finger, self.state()
        torque = pressures[:, None] * finger.pressure_gain - finger.stiffness * q
        if self._implicit:
            torque -= self._drag * (v + self._change(q, v, torque))
        self._client.setJointMotorControlArray(
            self._gripper.body, self._gripper.joints, pybullet.TORQUE_CONTROL, forces=torque.ravel().tolist()
        )

    def _change(self, q: Array, v: Array, torque: Array) -> Array:
        """Change of the rates in the next step, implicit in springs and damping, (F, N) rad/s."""
        mass = np.array(self._client.calculateMassMatrix(self._gripper.body, q.ravel().tolist()))
        torque = torque - self._drag * v + gravity_torque(self._finger, q, self._gravity)
        return np.linalg.solve(mass + self._metric, self._step * torque.ravel()).reshape(q.shape)
