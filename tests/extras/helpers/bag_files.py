"""Bags of ROS 1 and 2 and MCAP files, written from columns of numbers."""

import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from soft_gripper.arrays import Array

BEGIN = 1_700_000_000_000_000_000  # ns since 1970
DELAY = 2_000_000  # ns from the stamp of a message to its record
Series = dict[str, tuple[Array, Array]]  # by topic: times, s, (T,), and numbers, (T, n)


def stamps(times: Array) -> Iterator[int]:
    """Times in ns."""
    return (BEGIN + round(float(time) * 1e9) for time in times)


JOINTS, POINT, NUMBERS = (
    "sensor_msgs/msg/JointState",
    "geometry_msgs/msg/PointStamped",
    "std_msgs/msg/Float64MultiArray",
)


def _message(store: Any, kind: str, stamp: int, numbers: Iterable[float]) -> Any:
    """A JointState with the numbers as its positions, a PointStamped, or a Float64MultiArray."""
    types, values = store.types, np.array(list(numbers), dtype=float)
    if kind == NUMBERS:
        return types[kind](layout=types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0), data=values)
    sequence = {"seq": 0} if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    time = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="base", **sequence)
    if kind == POINT:
        return types[kind](header=header, point=types["geometry_msgs/msg/Point"](*values.tolist()))
    nothing = np.empty(0)
    return types[kind](header=header, name=["joint"] * len(values), position=values, velocity=nothing, effort=nothing)


def _in_order(series: Series) -> list[tuple[int, str, Array]]:
    found = [
        (stamp, topic, row)
        for topic, (times, rows) in series.items()
        for stamp, row in zip(stamps(times), rows, strict=True)
    ]
    return sorted(found, key=lambda each: each[0])


def write_ros(
    path: Path, series: Series, kinds: dict[str, str] | None = None, plugin: StoragePlugin | None = None
) -> Path:
    """Writes a ROS 2 bag with a storage plugin, or without one a ROS 1 bag; of JointState, but for `kinds`."""
    store = get_typestore(Stores.ROS1_NOETIC if plugin is None else Stores.ROS2_HUMBLE)
    kinds = dict.fromkeys(series, JOINTS) | (kinds or {})
    writer: Any = Writer1(path) if plugin is None else Writer2(path, version=9, storage_plugin=plugin)
    serialize: Callable[..., Any] = store.serialize_ros1 if plugin is None else store.serialize_cdr
    with writer as bag:
        connections = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for stamp, topic, row in _in_order(series):
            data = serialize(_message(store, kinds[topic], stamp, row), kinds[topic])
            bag.write(connections[topic], stamp + DELAY, data)
    return path


def write_json_mcap(path: Path, series: Series, kinds: dict[str, str] | None = None) -> Path:
    """Writes an MCAP file of JSON messages with the fields of a JointState, or a PointStamped if `kinds` says so."""
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        schema = writer.register_schema("numbers", "jsonschema", b'{"type": "object"}')
        channels = {topic: writer.register_channel(topic, "json", schema) for topic in series}
        for stamp, topic, row in _in_order(series):
            timestamp = {"sec": stamp // 10**9, "nsec": stamp % 10**9}
            value = [float(each) if np.isfinite(each) else None for each in row]
            is_point = (kinds or {}).get(topic) == POINT
            named = {"point": dict(zip("xyz", value, strict=True))} if is_point else {"position": value}
            data = json.dumps({"header": {"stamp": timestamp}, **named}).encode()
            writer.add_message(channels[topic], stamp + DELAY, data, stamp)
        writer.finish()
    return path


def write_named(path: Path, messages: Iterable[tuple[str, float, float, dict[str, float]]]) -> Path:
    """Writes a ROS 1 bag of messages: their publisher, their stamp and how late they are recorded, s, and positions.

    Each is a JointState on /joints, and a TFMessage on /tf whose children have these names and lie there along x.
    """
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"))
    types, empty = store.types, np.empty(0)
    joints, tf = types[JOINTS], types["tf2_msgs/msg/TFMessage"]
    transform, stamped = types["geometry_msgs/msg/Transform"], types["geometry_msgs/msg/TransformStamped"]
    vector, turn = types["geometry_msgs/msg/Vector3"], types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
    with Writer1(path) as bag:
        lines: dict[tuple[str, str], Any] = {}
        for publisher, at, late, positions in messages:
            (stamp,) = stamps(np.array([at]))
            time = types["builtin_interfaces/msg/Time"](sec=stamp // 10**9, nanosec=stamp % 10**9)
            header = types["std_msgs/msg/Header"](seq=0, stamp=time, frame_id="")
            values = np.array(list(positions.values()))
            frames = [
                stamped(header, name, transform(vector(value, 0.0, 0.0), turn)) for name, value in positions.items()
            ]
            for topic, kind, message in (
                ("/joints", joints, joints(header, list(positions), values, empty, empty)),
                ("/tf", tf, tf(frames)),
            ):
                if (topic, publisher) not in lines:
                    lines[topic, publisher] = bag.add_connection(
                        topic, kind.__msgtype__, typestore=store, callerid=publisher
                    )
                data = store.serialize_ros1(message, kind.__msgtype__)
                bag.write(lines[topic, publisher], stamp + round(late * 1e9), data)
    return path
