"""Computes the outputs of our blocks, with the same functions, for all samples of another simulator at once."""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators import BendSharing, arcs_from_readings, joints_on_arcs
from soft_gripper.load.force_estimator import SAMPLES, Motion, TorqueBalance, windows
from soft_gripper.sensors import SensorLayout, extension_ratios
from studies.peers.task import PeerTask


def sense(task: PeerTask, q: Array, pressure: Array) -> tuple[Array, Array, Planar, Array, Array]:
    """Strain, arcs, positions of the joints, joint angles and external torque of fingers that are alike and hang.

    Args:
        task: names the fingers and their sensors.
        q: joint angles, (T, F, N) rad.
        pressure: in the chambers, (T, F) Pa.
    """
    finger, sensor, gravity = task.fingers[0], task.scenario.sensor, np.array(task.scenario.gravity)
    layout = SensorLayout(finger, sensor.sections)
    strain = layout.response.reading(extension_ratios(layout, q))
    arcs = arcs_from_readings(layout, strain)
    driving = pressure[..., None] * finger.pressure_gain
    angles = BendSharing(layout).joint_angles(arcs.theta, driving, -complex(gravity[2]))
    X_WB = np.broadcast_to(np.array([[1.0, 0, 0, 0], [0, -1, 0, 0], [0, 0, -1, 0]]), (*pressure.shape, 3, 4))
    balance = TorqueBalance(finger)
    # Five samples each; at first there are fewer.
    histories = [
        np.concatenate([np.full((SAMPLES - 1, *values.shape[1:]), np.nan), values])
        for values in balance.samples(angles, driving, X_WB)
    ]
    motion = Motion(*(np.moveaxis(windows(history), 1, 2) for history in histories))
    external = balance.external_torque(motion, gravity, task.period)
    return strain, arcs.theta, joints_on_arcs(layout, arcs), angles, external.torque
