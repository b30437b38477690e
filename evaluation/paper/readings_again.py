"""A recorded finger read by other sensors: the estimates for any number of sections, from ONE simulation.

The sensors are read again from the recorded joint angles, by the very functions that the blocks call.
"""

from dataclasses import dataclass, replace

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.belief import believed_layout
from soft_gripper.diagrams.wiring.sensors import sensor_layout
from soft_gripper.estimation.torque_balance import SAMPLES, Motion, TorqueBalance, windows
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.shape.arcs import Arcs
from soft_gripper.shape.bend_sharing import BendSharing
from soft_gripper.shape.section_arcs import arcs_from_readings


@dataclass(frozen=True)
class ReadAgain:
    """The arcs of a recorded finger, (T, S), and sensors and finger as they are believed to be."""

    layout: SensorLayout
    arcs: Arcs


def read_again(station: Station, recording: Recording, finger: PlantFinger, sections: int) -> ReadAgain:
    """What the estimator `arcs` makes of another number of sections a side."""
    scenario, q = station.scenario, recording[f"{finger.name}.sampled_joint_angles"].values
    simulated = replace(sensor_layout(finger.finger, scenario.sensor), sections=sections)
    believed = replace(believed_layout(finger.finger, scenario.sensor, scenario.believed), sections=sections)
    readings = simulated.response.reading(extension_ratios(simulated, q))
    return ReadAgain(believed, arcs_from_readings(believed, readings))


def joint_angles_again(station: Station, recording: Recording, finger: PlantFinger, again: ReadAgain) -> Array:
    """The estimated joint angles for these readings at every sample, rad, (T, N)."""
    pressure, X_WB = (recording[f"{finger.name}.{name}"].values for name in ("sampled_pressure", "X_WB"))
    in_plane = (X_WB[:, :, 2] + 1j * X_WB[:, :, 0]) @ _gravity(station)
    return BendSharing(again.layout).joint_angles(again.arcs.theta, pressure, in_plane[:, None])


def external_torque_again(station: Station, recording: Recording, finger: PlantFinger, again: ReadAgain) -> Array:
    """The external torque for these readings at every sample, N m, (T, N); NaN until there are five samples."""
    q = joint_angles_again(station, recording, finger, again)
    pressure, X_WB = (recording[f"{finger.name}.{name}"].values for name in ("sampled_pressure", "X_WB"))
    motion = Motion(*map(windows, (q, pressure, X_WB)))
    balance = TorqueBalance(again.layout.finger)
    torque = balance.external_torque(motion, _gravity(station), station.scenario.sensor.period).torque
    # The first sample is recorded twice: a log at a time still shows the sample before.
    return np.concatenate([np.full((SAMPLES, q.shape[-1]), np.nan), torque[1:]])


def _gravity(station: Station) -> Array:
    """As it is taken out of the external torque, in the world, (3,) m/s^2."""
    return np.array(station.scenario.gravity) * station.scenario.estimator.compensate_gravity
