"""A pick-and-place station and recordings made up for it: what the tests of trials look at."""

from collections.abc import Mapping

import numpy as np
import xarray as xr
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.scenario.scenario_file import load_scenario

LOOKED_FOR = "estimator.contact_threshold=2.5e-3"
FINGERS = ("left_finger", "right_finger")


def box_station() -> Station:
    """The station of `pick_and_place_box`, with contact looked for."""
    return make_station(load_scenario("pick_and_place_box", [LOOKED_FOR]))


def state(station: Station, X_WO: RigidTransform, positions: Mapping[str, float]) -> Array:
    """A state of the plant at rest: the object's pose, and positions of joints, rad; the others stay as they are."""
    plant = station.plant
    context = plant.CreateDefaultContext()
    plant.SetFreeBodyPose(context, plant.GetBodyByName("box"), X_WO)
    for joint, position in positions.items():
        plant.GetJointByName(joint).set_angle(context, position)
    return plant.GetPositionsAndVelocities(context)


def recording(signals: Mapping[str, Array]) -> Recording:
    """Signals every 10 ms."""
    length = len(next(iter(signals.values())))
    variables = {
        name: (["time", *(f"{name}_{i}" for i in range(values.ndim - 1))], values) for name, values in signals.items()
    }
    return Recording(xr.Dataset(variables, {"time": 0.01 * np.arange(length)}))


def box_recording(station: Station, signals: Mapping[str, Array]) -> Recording:
    """Signals every 10 ms, and the pose of the box, as the plant's state has it."""
    first = station.plant.GetBodyByName("box").floating_positions_start()
    return recording({**signals, "box.pose": signals["plant.state"][:, first : first + 7]})
