"""The tasks in PyBullet."""

from time import process_time

import numpy as np
import pybullet
from pybullet_utils.bullet_client import BulletClient

from soft_gripper.arrays import Array
from soft_gripper.fingers import forward_kinematics, gravity_torque
from studies.peers.bullet_model import BulletGripper, add_scene
from studies.peers.sensing import sense
from studies.peers.task import PeerTask, PeerTrial, Run, Setting


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
