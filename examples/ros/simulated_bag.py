"""Writes the bag of free bending that the how-to page on ROS uses, for those who have none: the folder `free`.

The simulated finger is 8 % softer than its file, my_finger.yaml in the current folder. The bag has the counts of four
gauges, the pressure, and the tip as a camera sees it:

    python examples/ros/simulated_bag.py
"""

from pathlib import Path

import numpy as np
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import soft_gripper as sg

STEPS = [0, 40e3, 80e3, 120e3, 150e3, 110e3, 70e3, 30e3, 0, 60e3, 120e3, 0]  # Pa
CHANGES = [
    "models.finger.fingers.all.youngs_modulus=-8 %",
    "models.finger.fingers.all.layer_modulus=-8 %",
    "sensor.errors={gain_error: 0.03, offset: 0.005, hysteresis: 0.01, noise: 2.0e-3}",
    f"pressure.steps.all={STEPS}",
    "pressure.settle=0.5",
    "pressure.hold_samples=60",
    "estimator.type=arcs",
]
TOPICS = {
    "/gauges": "sensor_msgs/msg/JointState",
    "/supply": "sensor_msgs/msg/FluidPressure",
    "/tip": "geometry_msgs/msg/PointStamped",
}


def main():
    """Simulates free bending and writes its messages."""
    data = sg.simulate(sg.load_scenario("my_finger.yaml", CHANGES)).data
    store = get_typestore(Stores.LATEST)
    types = store.types
    with Writer(Path("free"), version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        topics = {name: bag.add_connection(name, kind, typestore=store) for name, kind in TOPICS.items()}
        for i, t in enumerate(data["time"].values):
            stamp = types["builtin_interfaces/msg/Time"](sec=int(t), nanosec=int(1e9 * (t % 1)))
            header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="base")
            counts, nothing = data["finger.strain"].values[i].ravel().round(), np.empty(0)
            tip = data["finger.true_tip_position"].values[i].round(4)
            messages = {
                "/gauges": {"name": ["a", "b", "c", "d"], "position": counts, "velocity": nothing, "effort": nothing},
                "/supply": {"fluid_pressure": float(data["finger.sampled_pressure"].values[i]), "variance": 0.0},
                "/tip": {"point": types["geometry_msgs/msg/Point"](*tip)},
            }
            for name, fields in messages.items():
                message = types[TOPICS[name]](header=header, **fields)
                bag.write(topics[name], int(1e9 * t), store.serialize_cdr(message, TOPICS[name]))


if __name__ == "__main__":
    main()
