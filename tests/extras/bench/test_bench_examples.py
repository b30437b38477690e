"""The examples of a bench: a node of ROS, a cup held over a network, LCM, and simulated hardware."""

import re
import runpy
import subprocess
import sys
import time
from collections import defaultdict
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from simulated_hardware import SimulatedHardware

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.endpoints import Endpoints
from soft_gripper.registry import OWN
from soft_gripper.scenario.scenario_file import load_scenario

NODE = Path(__file__).parents[3] / "examples" / "ros" / "gripper_node.py"
BENCH = """source: "ros:"
format: text
fields: [t, a0, a1, a2, a3, pa, b0, b1, b2, b3, pb]
time: t
pressure_unit: kPa
stale_after: 10 # s: this machine may be busy
fingers:
  left_finger: { readings: [a0, a1, a2, a3], pressures: [pa] }
  right_finger: { readings: [b0, b1, b2, b3], pressures: [pb] }
"""
FIELDS = BENCH.splitlines()[2].partition("[")[2].rstrip("]").split(", ")
CHANGES = [
    *("estimator.type=contact", "estimator.uncertainty.bend_per_pressure=0.005", "sensor.sections=2"),
    *("control.set_points=[0.06]", "control.hold=0.3"),
]
MESSAGES = {
    "geometry_msgs": ("Point", "Pose", "PoseArray", "Quaternion", "Vector3", "Wrench", "WrenchStamped"),
    "sensor_msgs": ("JointState",),
    "std_msgs": ("Float64MultiArray", "Header"),
}


class Message(SimpleNamespace):
    """A message of any type."""


class Ros:
    """A stub of rclpy: messages of a list arrive one after the other; what is published is kept by topic."""

    def __init__(self, topic, messages):
        self.published, self._callbacks, self._left = defaultdict(list), {}, list(messages)
        self._topic = topic
        self.clock = Message(now=lambda: Message(to_msg=lambda: "now"))

    def module(self):
        return SimpleNamespace(
            init=lambda args: None,
            create_node=lambda name: self,
            spin_once=self.spin_once,
            ok=lambda: bool(self._left),
            try_shutdown=lambda: None,
        )

    def spin_once(self, node, timeout_sec):
        self._callbacks[self._topic](self._left.pop(0))

    def create_subscription(self, kind, topic, callback, depth):
        self._callbacks[topic] = callback

    def create_publisher(self, kind, topic, depth):
        return SimpleNamespace(publish=self.published[topic].append)

    def get_clock(self):
        return self.clock

    def destroy_node(self):
        self._callbacks.clear()


@pytest.fixture
def stubbed(monkeypatch):
    """The file run where ROS is installed."""
    for package, names in MESSAGES.items():
        monkeypatch.setitem(sys.modules, package, ModuleType(package))
        module = ModuleType(f"{package}.msg")
        for name in names:
            setattr(module, name, type(name, (Message,), {}))
        monkeypatch.setitem(sys.modules, f"{package}.msg", module)
    monkeypatch.setitem(sys.modules, "rclpy", ModuleType("rclpy"))
    return runpy.run_path(str(NODE), run_name="gripper_node")


@pytest.fixture(scope="module")
def run():
    """A scenario, and what its sensors read, sample by sample."""
    scenario = load_scenario("tip_distance_steps", CHANGES)
    data = run_station(make_station(scenario)).data
    rows = [data["time"].values[:, None]]
    for finger in ("left_finger", "right_finger"):
        strain, pressure = (data[f"{finger}.{name}"].values for name in ("strain", "sampled_pressure"))
        rows += [strain.reshape(len(strain), -1), pressure[:, None] / 1e3]
    return scenario, np.hstack(rows)[1:]


def published(stubbed, tmp_path, topic, messages):
    (tmp_path / "bench.yaml").write_text(BENCH)
    ros = Ros(topic, messages)
    stubbed["main"].__globals__["rclpy"] = ros.module()
    changes = [part for change in CHANGES for part in ("--set", change)]
    assert stubbed["main"](["tip_distance_steps", "--bench", str(tmp_path / "bench.yaml"), *changes]) == 0
    return ros.published


def named(rows):
    order = np.argsort(FIELDS[::-1])  # names may come in any order
    fields = np.array(FIELDS[::-1])[order]
    for i, row in enumerate(rows):
        values = row[::-1][order]
        yield Message(header=Message(stamp=f"stamp {i}"), name=fields.tolist(), position=values.tolist())


def test_estimates_are_those_of_the_bench(stubbed, tmp_path, run):
    scenario, rows = run
    found = published(stubbed, tmp_path, "~/readings", named(rows))
    bench = Bench(scenario)
    for row in rows:
        values = {"left_finger": row[1:6], "right_finger": row[6:]}
        bench.step(
            {f"{name}.strain": value[:4] for name, value in values.items()}
            | {f"{name}.pressure": 1e3 * value[4:] for name, value in values.items()}
        )
    joints = found["~/joint_states"]
    assert len(joints) == len(rows)
    assert [each.header.stamp for each in joints] == [f"stamp {i}" for i in range(len(rows))]
    q = bench.read(["left_finger.estimated_joint_angles", "right_finger.estimated_joint_angles"])
    np.testing.assert_allclose(joints[-1].position, np.concatenate(list(q.values())), atol=1e-12)
    X_WB, pose = bench.read(["left_finger.X_WB", "left_finger.tip_pose"]).values()
    X_WB = X_WB.reshape(3, 4)
    *_, tip = found["~/left_finger/shape"][-1].poses
    expected = X_WB @ [pose[0], 0, pose[1], 1]
    np.testing.assert_allclose([tip.position.x, tip.position.y, tip.position.z], expected, atol=1e-12)
    turned = Rotation.from_quat([getattr(tip.orientation, axis) for axis in "xyzw"]).as_matrix()
    np.testing.assert_allclose(X_WB[:, :3].T @ turned, Rotation.from_rotvec([0, pose[2], 0]).as_matrix(), atol=1e-9)
    u = bench.read(["left_finger.pressure_command", "right_finger.pressure_command"])
    *_, last = (each.data for each in found["~/commands"] if any(each.data))  # safe ones follow
    np.testing.assert_allclose(last, np.concatenate(list(u.values())) / 1e3, rtol=1e-12)


def test_the_wrench_is_that_of_the_force_in_its_place(stubbed, tmp_path):
    """Fingers that stay straight under pressure are pressed, here at the tip."""
    row = np.array([0, *(0, 0, 0, 0, 60), *(0, 0, 0, 0, 60)], dtype=float)
    found = published(stubbed, tmp_path, "~/numbers", [Message(data=row.tolist())] * 3)
    bench = Bench(load_scenario("tip_distance_steps", CHANGES))
    for _ in range(3):
        bench.step({name: np.zeros(size) if "strain" in name else [60e3] for name, size in bench.inputs.items()})
    (estimated,), (s,) = bench.read(
        [f"left_finger.{name}" for name in ("contact_force", "contact_arc_length")]
    ).values()
    assert (abs(estimated) > 0.1, s) == (True, pytest.approx(0.12))
    tip = found["~/left_finger/shape"][-1].poses[-1]
    p, xyzw = (np.array([getattr(tip.position, a) for a in "xyz"]), [getattr(tip.orientation, a) for a in "xyzw"])
    inward = Rotation.from_quat(xyzw).apply([1, 0, 0])
    wrench = found["~/left_finger/contact"][-1].wrench
    force, torque = (np.array([getattr(vector, axis) for axis in "xyz"]) for vector in (wrench.force, wrench.torque))
    np.testing.assert_allclose(force, -estimated * inward, atol=1e-9)
    np.testing.assert_allclose(torque, np.cross(p, force), atol=1e-4 * abs(estimated))
    assert found["~/left_finger/contact"][-1].header.frame_id == "world"


def test_messages_that_do_not_fit_are_passed_over(stubbed, tmp_path, run):
    _, rows = run
    cut = [Message(data=rows[0][:5].tolist()), Message(data=[*rows[0][:-1], float("nan")])]
    found = published(stubbed, tmp_path, "~/numbers", [*cut, Message(data=rows[0].tolist())])
    assert len(found["~/joint_states"]) == 1


EXAMPLES = Path(__file__).parents[3] / "examples" / "bench"
SECONDS = 16.0


@pytest.mark.slow
def test_a_cup_is_held_through_the_protocol(tmp_path):
    """Closed over UDP in real time, two realistic sensors per side, exact model: lifted, and never above 0.9 N."""
    live = [Path(sys.executable).with_name("soft-gripper"), "live", EXAMPLES / "held_cup.yaml"]
    live += ["--bench", EXAMPLES / "held_cup_bench.yaml"]
    hardware = [sys.executable, EXAMPLES / "simulated_hardware.py", EXAMPLES / "held_cup.yaml"]
    with subprocess.Popen(live, stderr=subprocess.PIPE, text=True, cwd=tmp_path) as ours:
        time.sleep(8)  # until it listens
        with subprocess.Popen([*hardware, "--out", tmp_path / "cup.nc"]) as theirs:
            time.sleep(SECONDS + 8)
            theirs.terminate()
        ours.terminate()
        said = ours.communicate()[1]
    counted = {word: int(number) for number, word in re.findall(r"(\d+) (\w+)", said.partition("Readings:")[2])}
    if counted["silences"] > 2:  # before the first reading, and after the last
        pytest.skip(f"this machine was too busy for real time: {counted['silences']} silences")
    assert counted["used"] > 100 * SECONDS
    assert counted["malformed"] == counted["repeated"] == counted["lost"] == 0
    recording = Recording.load(tmp_path / "cup.nc")
    time_held = recording.data.time.values > 14
    assert time_held.sum() > 100
    height = recording["cup.pose"].values[:, -1]
    assert height[time_held].min() > height[0] + 0.09
    forces = np.array([recording[f"{side}_finger.normal_force"].values for side in ("left", "right")])
    assert forces.max() < 0.9
    assert forces[:, time_held].min() > 0.3


ENDS = Path(__file__).parents[3] / "examples" / "bench" / "lcm_ends.py"


def test_numbers_arrive_by_name():
    publish = OWN.find(f"{ENDS}:publish", "sink")
    with Endpoints("bench.yaml") as endpoints:
        source, arrived, end = endpoints.source(f"{ENDS}:readings"), [], time.monotonic() + 2.0
        while not arrived and time.monotonic() < end:
            publish({"count": 3, "left_finger.strain": [0.01, -0.02]}, channel="READINGS")
            arrived = source.receive(0.05)
    if not arrived:
        pytest.skip("LCM is not possible here: no message arrives by multicast")
    assert arrived[0] == {"count": 3.0, "left_finger.strain[0]": 0.01, "left_finger.strain[1]": -0.02}


SET_POINT = 0.06  # m, the first of the scenario
COMMANDS = [f"{side}_finger.pressure_command" for side in ("left", "right")]


def test_the_opening_reaches_its_set_point():
    scenario = load_scenario("tip_distance_steps")
    hardware, bench = SimulatedHardware(scenario), Bench(scenario)
    for _ in range(230):
        message = hardware.message()
        bench.step({name: np.ravel(message[name]) for name in bench.inputs})
        hardware.command(bench.read(COMMANDS))
    assert bench.read(["grip.opening"])["grip.opening"][0] == pytest.approx(SET_POINT, abs=2e-3)
