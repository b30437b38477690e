"""A task as PyBullet bodies: the expanded URDF, read by PyBullet itself, and the bodies around it."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import pybullet
from pybullet_utils.bullet_client import BulletClient
from pydrake.math import RigidTransform

from soft_gripper.fingers import Finger
from soft_gripper.fingers.finger_links import joint_name
from soft_gripper.truth.contact import combined_friction
from studies.peers.bodies import Body
from studies.peers.task import PeerTask, Setting

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
