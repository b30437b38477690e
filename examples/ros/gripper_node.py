"""A ROS 2 node: readings of sensors in; shape, contact, joint angles and commands out.

    python gripper_node.py my_scenario.yaml --bench my_bench.yaml
    python gripper_node.py my_scenario.yaml --bench my_bench.yaml --ros-args -r ~/readings:=/gauges

The description of the bench is that of `soft-gripper live`; its source and sink are not used. rclpy is imported if it
is installed.

| topic | type | what |
|---|---|---|
| ~/readings, in | sensor_msgs/JointState | numbers (position) by the names of the fields in the description |
| ~/numbers, in | std_msgs/Float64MultiArray | the same without names, in the order of its `fields` |
| ~/{finger}/shape | geometry_msgs/PoseArray | base, joints and tip in the world; z along the finger |
| ~/{finger}/contact | geometry_msgs/WrenchStamped | estimated contact force, and its torque about the world's origin |
| ~/joint_states | sensor_msgs/JointState | estimated angles, by the names of `soft-gripper expand` |
| ~/commands | std_msgs/Float64MultiArray | of the grip controller, finger after finger; safe ones if readings stop |
"""

import argparse
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from scipy.spatial.transform import Rotation

import soft_gripper as sg
from soft_gripper.diagrams.view.finger_drawing import (
    drawn_signals,
    estimated_corners,
    force_in_world,
    link_frames,
    to_world,
)
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import COMMANDS, BenchDriver
from soft_gripper.extras.bench.commands.live import check_inputs
from soft_gripper.extras.hardware.bench_schema import load_bench
from soft_gripper.extras.page.session import Session
from soft_gripper.fingers.finger_links import joint_name

try:
    import rclpy
    from geometry_msgs.msg import Point, Pose, PoseArray, Quaternion, Vector3, Wrench, WrenchStamped
    from sensor_msgs.msg import JointState
    from std_msgs.msg import Float64MultiArray, Header
except ImportError:
    rclpy = None

WORLD = "world"
DEPTH = 50  # messages that a queue holds
MAX_STAMPS = 1000


class RosSource:
    """Readings that arrive as messages, by the names of their fields; numbered here if their device does not.

    Messages arrive while earlier ones are estimated: `stamps` are those of the last, by the number of the reading.
    """

    def __init__(self, node, config):
        config.count = config.count or "number"
        self._node, self._config, self._arrived, self._number, self.stamps = node, config, [], 0, {}
        node.create_subscription(JointState, "~/readings", self._take_named, DEPTH)
        node.create_subscription(Float64MultiArray, "~/numbers", self._take_numbers, DEPTH)

    @property
    def is_over(self):
        """Whether the node is shut down."""
        return not rclpy.ok()

    def receive(self, timeout):
        """Messages that have arrived; waits up to `timeout` s for the first."""
        rclpy.spin_once(self._node, timeout_sec=timeout)
        arrived, self._arrived = self._arrived, []
        return arrived

    def _take_named(self, message):
        self._take(message.header.stamp, message.name, message.position)

    def _take_numbers(self, message):
        self._take(self._node.get_clock().now().to_msg(), self._config.fields, message.data)

    def _take(self, stamp, names, values):
        self._number += 1
        reading = {"number": self._number, **dict(zip(names, values, strict=False))}
        self._arrived.append(reading)
        self.stamps[reading.get(self._config.count)] = stamp
        if len(self.stamps) > MAX_STAMPS:
            del self.stamps[next(iter(self.stamps))]


class RosSink:
    """Publishes the estimates of each finger after a reading, and every command."""

    def __init__(self, node, bench, source):
        self._bench, self._source = bench, source
        self._fingers = list(bench.quantities)
        self._shapes = {f: node.create_publisher(PoseArray, f"~/{f}/shape", DEPTH) for f in self._fingers}
        self._contacts = {f: node.create_publisher(WrenchStamped, f"~/{f}/contact", DEPTH) for f in self._fingers}
        self._joints = node.create_publisher(JointState, "~/joint_states", DEPTH)
        self._commands = node.create_publisher(Float64MultiArray, "~/commands", DEPTH)

    def __call__(self, _, results):
        commands = [value for name, value in results.items() if name.rpartition(".")[2] in COMMANDS]
        if commands:
            self._commands.publish(Float64MultiArray(data=np.concatenate(commands).tolist()))
        if results.get("age") != 0:
            return  # no new reading
        header = Header(stamp=self._source.stamps[results["count"]], frame_id=WORLD)
        names, angles = [], []
        for finger in self._fingers:
            state = finger_state(self._bench, finger)
            poses = [Pose(position=_point(p), orientation=_quaternion(R)) for p, R in state.poses]
            self._shapes[finger].publish(PoseArray(header=header, poses=poses))
            if state.force is not None:
                torque = np.nan_to_num(np.cross(state.location, state.force))  # no force has no location
                wrench = Wrench(force=_vector(state.force), torque=_vector(torque))
                self._contacts[finger].publish(WrenchStamped(header=header, wrench=wrench))
            names += [joint_name(finger.rpartition(".")[2], i) for i in range(len(state.angles))]
            angles += state.angles.tolist()
        self._joints.publish(JointState(header=header, name=names, position=angles))


def finger_state(bench, finger):
    """Poses of base, joints and tip in the world, angles, contact force and its location, NaN or None if unknown."""
    own = [name.removeprefix(f"{finger}.") for name in bench.signals if name.startswith(f"{finger}.")]
    names = [*drawn_signals(own), "X_WB", "estimated_joint_angles"]
    read = dict(zip(names, bench.read([f"{finger}.{name}" for name in names]).values(), strict=True))
    read["X_WB"] = X_WB = read["X_WB"].reshape(3, 4)
    corners = estimated_corners(read)
    frames = X_WB[:, :3] @ link_frames(corners)
    poses = list(zip(to_world(X_WB, corners), [*frames, frames[-1]], strict=True))
    location, force = force_in_world(read, corners) or (None, None)
    return SimpleNamespace(poses=poses, angles=read["estimated_joint_angles"], location=location, force=force)


def _point(p):
    return Point(x=float(p[0]), y=float(p[1]), z=float(p[2]))


def _vector(v):
    return Vector3(x=float(v[0]), y=float(v[1]), z=float(v[2]))


def _quaternion(R):
    x, y, z, w = Rotation.from_matrix(R).as_quat().tolist()
    return Quaternion(x=x, y=y, z=z, w=w)


def main(arguments=None):
    """Runs the node until it is shut down."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", help="name or file of a scenario")
    parser.add_argument("--bench", type=Path, required=True, help="description of the hardware")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="change the scenario")
    options, of_ros = parser.parse_known_args(arguments)
    if rclpy is None:
        return "gripper_node: rclpy cannot be imported: source the setup file of ROS 2, with Python 3.11 or newer"
    config = load_bench(options.bench)
    moving = [name for name, finger in config.fingers.items() if finger.base_pose is not None]
    bench = Bench(sg.load_scenario(options.scenario, options.set), moving)
    check_inputs(options.bench, config, bench)
    rclpy.init(args=of_ros)
    node = rclpy.create_node("soft_gripper")
    source = RosSource(node, config)
    try:
        Session(BenchDriver(bench, config, source, RosSink(node, bench, source))).run(lambda: False)
    finally:
        node.destroy_node()
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    sys.exit(main())
