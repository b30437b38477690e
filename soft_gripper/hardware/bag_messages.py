"""Messages of ROS 1 bags, ROS 2 bags and MCAP files (https://mcap.dev) -> columns of numbers.

A column is a topic and a field of its messages, such as `/joint_states.position[2]`; a time stamp, `header.stamp`, is
in seconds, and `log_time` is when the message was recorded. The messages of one topic, that of the time, are the rows;
of every other topic, a row has the last message before or at it, unless that is too old. Messages are ordered by the
stamp that is the time, where they have it, and else by when they were recorded.

It runs in a process of its own (`reading_apart`), and imports what it needs there.
"""

import json
import re
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, fields, is_dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError

_LOGGED = ("log_time",)
_SECOND = 10**9  # ns
_MOST_SHOWN = 30  # topics or fields in a message

Messages = Iterator[tuple[str, int, Any]]  # topic, when it was recorded, ns, and message, in this order of time


class Bag(NamedTuple):
    """An open file."""

    topics: Mapping[str, str]  # types of the messages, by topic
    messages: Callable[[Collection[str]], Messages]  # of some topics


class Column(NamedTuple):
    """A field of the messages of a topic."""

    name: str
    topic: str
    path: tuple[str | int, ...]


@dataclass
class Series:
    """The messages of a topic, as far as columns need them."""

    columns: list[Column]
    clock: list[int] = field(default_factory=list)  # ns
    values: list[list[float]] = field(default_factory=list)


def bag_columns(path: Path, time: str, columns: Iterable[str], hold: float) -> Array:
    """Columns of numbers, (T, 1 + len(columns)), the time first.

    Args:
        path: a ROS 1 bag, the folder or the database of a ROS 2 bag, or an MCAP file.
        time: column whose topic gives the rows; a stamp is counted from the first row, s.
        columns: other columns; NaN in rows for which there is none.
        hold: age, s, up to which a message of one topic is used in the rows of another.

    Raises:
        InputError: if there is no such topic or field.
    """
    with ExitStack() as stack:
        bag = (_mcap if path.suffix == ".mcap" else _ros_bag)(path, stack)
        rows_of, *others = (_column(path, name, bag.topics) for name in (time, *columns))
        series = {column.topic: Series([]) for column in (rows_of, *others)}
        for column in others:
            series[column.topic].columns.append(column)
        times = _read(path, bag, series, rows_of)
    rows = series[rows_of.topic].clock
    if not rows:
        raise InputError(path, "column", time, "there are no messages of this topic")
    found = {rows_of.name: times}
    for topic, each in series.items():
        held = _held(each, rows, None if topic == rows_of.topic else hold)
        found |= {column.name: held[:, i] for i, column in enumerate(each.columns)}
    return np.column_stack([found[column.name] for column in (rows_of, *others)])


def _read(path: Path, bag: Bag, series: Mapping[str, Series], rows_of: Column) -> Array:
    """Fills the series; returns the times of the rows, s, (T,)."""
    times: list[float] = []
    for topic, logged, message in bag.messages(series):
        each = series[topic]
        stamp = _stamp_at(message, rows_of.path)
        each.clock.append(logged if stamp is None else stamp)
        if topic == rows_of.topic:
            is_clock = stamp is not None or rows_of.path == _LOGGED
            first = each.clock[0]
            times.append((each.clock[-1] - first) / _SECOND if is_clock else _number(path, rows_of, message, logged))
        each.values.append([_number(path, column, message, logged) for column in each.columns])
    return np.array(times)


def _held(series: Series, rows: list[int], hold: float | None) -> Array:
    """The values of each row, (T, columns); `hold` None: the rows are those of the series."""
    values = np.array(series.values, dtype=float).reshape(len(series.clock), len(series.columns))
    if hold is None:
        return values
    order = np.argsort(series.clock, kind="stable")
    clock = [series.clock[i] for i in order]
    held = np.full((len(rows), len(series.columns)), np.nan)
    for row, at in enumerate(rows):
        last = bisect_right(clock, at) - 1
        if last >= 0 and at - clock[last] <= hold * _SECOND:
            held[row] = values[order[last]]
    return held


def _column(path: Path, name: str, topics: Mapping[str, str]) -> Column:
    topic = max((topic for topic in topics if name.startswith(f"{topic}.")), key=len, default=None)
    if topic is None:
        known = _listed(f"{topic} ({kind})" for topic, kind in sorted(topics.items()))
        expected = f"give a topic and a field, as in /topic.field[0]; the topics of the file: {known}"
        raise InputError(path, "column", name, expected)
    parts = re.findall(r"[^.\[\]]+|\[\d+\]", name[len(topic) + 1 :])
    return Column(name, topic, tuple(int(part[1:-1]) if part[0] == "[" else part for part in parts))


def _number(path: Path, column: Column, message: Any, logged: int) -> float:
    """A number of a message; NaN where there is none, s of stamps."""
    if column.path == _LOGGED:
        return logged / _SECOND
    try:
        value = _at(message, column.path)
    except IndexError:
        return np.nan  # a list may be shorter in some messages
    except (LookupError, AttributeError, TypeError):
        raise _unknown(path, column, message) from None
    if (stamp := _stamp(value)) is not None:
        return stamp / _SECOND
    if value is None:
        return np.nan
    if isinstance(value, bool | int | float | np.number | np.bool_):
        return float(value)
    raise _unknown(path, column, message)


def _unknown(path: Path, column: Column, message: Any) -> InputError:
    known = _listed([*_leaves(message), *_LOGGED])
    return InputError(path, "column", column.name, f"is not a number of {column.topic}, which has: {known}")


def _at(message: Any, path: Iterable[str | int]) -> Any:
    for part in path:
        message = message[part] if isinstance(part, int) or isinstance(message, dict) else getattr(message, part)
    return message


def _stamp_at(message: Any, path: tuple[str | int, ...]) -> int | None:
    try:
        return _stamp(_at(message, path))
    except (LookupError, AttributeError, TypeError):
        return None


def _stamp(value: Any) -> int | None:
    """A time in ns, of ROS or of JSON; None if it is none."""
    parts = value if isinstance(value, dict) else getattr(value, "__dict__", {})
    nanoseconds = parts.get("nanosec", parts.get("nsec"))
    if nanoseconds is None or "sec" not in parts:
        return None
    return int(parts["sec"]) * _SECOND + int(nanoseconds)


def _leaves(value: Any, name: str = "") -> Iterator[str]:
    """The numbers and texts in a message, as columns name them; `[0..3]` stands for four entries."""
    if isinstance(value, dict):
        parts = value
    elif is_dataclass(value):
        parts = {each.name: getattr(value, each.name) for each in fields(value) if not each.name.startswith("__")}
    elif isinstance(value, list | tuple | np.ndarray) and len(value):
        yield from _leaves(value[0], f"{name}[0..{len(value) - 1}]")
        return
    else:
        yield name if not isinstance(value, str) else f"{name} (text)"
        return
    for key, part in parts.items():
        yield from _leaves(part, f"{name}.{key}" if name else str(key))


def _listed(names: Iterable[str]) -> str:
    found = list(names)
    return ", ".join([*found[:_MOST_SHOWN], *(["..."] if len(found) > _MOST_SHOWN else [])]) or "none"


def _ros_bag(path: Path, stack: ExitStack) -> Bag:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    # Databases of older versions of ROS 2 do not define their messages.
    reader = stack.enter_context(AnyReader([path], default_typestore=get_typestore(Stores.LATEST)))

    def messages(topics: Collection[str]) -> Messages:
        chosen = [each for each in reader.connections if each.topic in topics]
        for connection, logged, data in reader.messages(chosen):
            yield connection.topic, logged, reader.deserialize(data, connection.msgtype)

    return Bag({each.topic: each.msgtype for each in reader.connections}, messages)


def _mcap(path: Path, stack: ExitStack) -> Bag:
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    reader = make_reader(stack.enter_context(path.open("rb")), validate_crcs=True)
    store, registered = get_typestore(Stores.EMPTY), set[str]()

    def decoded(schema: Any, channel: Any, data: bytes) -> Any:
        if channel.message_encoding == "json":
            return json.loads(data)
        kinds = {"cdr": ("ros2msg", store.deserialize_cdr), "ros1": ("ros1msg", store.deserialize_ros1)}
        defined, deserialize = kinds.get(channel.message_encoding, ("", None))
        if deserialize is None or schema is None or schema.encoding != defined:
            expected = (
                f"its messages are encoded as '{channel.message_encoding}'; json, cdr (ros2msg) and ros1 are read"
            )
            raise InputError(path, "topic", channel.topic, expected)
        if schema.name not in registered:
            store.register(get_types_from_msg(schema.data.decode(), schema.name))
            registered.add(schema.name)
        kind = schema.name if schema.name in store.fielddefs else schema.name.replace("/", "/msg/", 1)
        return deserialize(data, kind)

    def messages(topics: Collection[str]) -> Messages:
        for schema, channel, message in reader.iter_messages(topics=list(topics)):
            yield channel.topic, message.log_time, decoded(schema, channel, message.data)

    summary = reader.get_summary()
    if summary is None:
        raise InputError(path, "file", path.name, "was not closed: it has no index; repair it with `mcap recover`")
    schemas = {number: schema.name for number, schema in summary.schemas.items()}
    return Bag({each.topic: schemas.get(each.schema_id, "") for each in summary.channels.values()}, messages)
