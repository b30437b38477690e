"""Computes what our blocks compute at every sample, with the same functions, for all fingers of another simulator."""

import numpy as np

from peers.task import Task
from soft_gripper.arrays import Array
from soft_gripper.estimators import BendSharing, arcs_from_readings, joints_on_arcs
from soft_gripper.load import Motion, TorqueBalance
from soft_gripper.load.force_estimator import SAMPLES
from soft_gripper.sensors import SensorLayout, extension_ratios


class Sensing:
    """Strain, arcs, positions of the joints, joint angles and external torque; keeps what it was given."""

    def __init__(self, task: Task):
        """For the fingers of a task, which are alike and hang straight down."""
        finger, sensor = task.fingers[0], task.scenario.sensor
        self._layout = SensorLayout(finger, sensor.sections)
        self._sharing, self._balance = BendSharing(self._layout), TorqueBalance(finger)
        self._gain, self._gravity = finger.pressure_gain, np.array(task.scenario.gravity)
        self._period, fingers = task.period, len(task.fingers)
        self._q, self._driving = np.full((2, fingers, SAMPLES, finger.segments), np.nan)
        hangs = np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0]])
        self._X_WB = np.broadcast_to(hangs, (fingers, SAMPLES, 3, 4))
        self.recorded: list[tuple[Array, ...]] = []

    def sample(self, q: Array, pressure: Array) -> None:
        """Takes joint angles (F, N) rad and pressures (F,) Pa."""
        strain = self._layout.response.reading(extension_ratios(self._layout, q))
        arcs = arcs_from_readings(self._layout, strain)
        joints = joints_on_arcs(self._layout, arcs)
        driving = pressure[:, None] * self._gain
        angles = self._sharing.joint_angles(arcs.theta, driving, -complex(self._gravity[2]))
        for samples, present in ((self._q, angles), (self._driving, driving)):
            samples[:, :-1] = samples[:, 1:]
            samples[:, -1] = present
        motion = Motion(self._q, self._driving, self._X_WB)
        external = self._balance.external_torque(motion, self._gravity, self._period)
        self.recorded.append((strain, arcs.theta, joints, angles, external.torque))
