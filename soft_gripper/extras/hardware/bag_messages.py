"""Messages of ROS 1 bags, ROS 2 bags and MCAP files (https://mcap.dev) -> columns of numbers.

A column is a topic and a field of its messages, such as `/joint_states.position[2]`; a time stamp, `header.stamp`, is
in seconds, and `log_time` is when the message was recorded. An entry of a list is named by its place or by its name,
`/joint_states.position[wrist]`, `/tf.transforms[tip].transform.translation.x`; one that has another name in other
messages must be named so. The messages of one topic, that of the time, are the rows; of every other topic, a row has
the last message before or at it, unless that is too old. Messages that lack an entry of the name are passed over.
Messages are ordered by the stamp that is the time, where they have it, and else by when they were recorded.

It runs in a process of its own (`reading_apart`), and imports what it needs there.
"""

import re
from bisect import bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, fields, is_dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.json_text import parse_json
from soft_gripper.files.notes import LEFT_OUT, MENDED, note
from soft_gripper.files.number import number

_LOGGED = ("log_time",)
_SECOND = 10**9  # ns
_MOST_LATE = 10**9  # ns, by which a message may be stamped before another that was recorded earlier
_MOST_DIGITS = 9  # of the place of an entry
_MOST_SHOWN = 30  # topics or fields in a message
_NAMES = "name", "names", "joint_names"  # fields with the names of the entries of the lists beside them
_OWN_NAMES = "child_frame_id", "name"  # fields with the name of an entry


class Message(NamedTuple):
    """A message, with where it comes from."""

    topic: str
    publisher: str
    logged: int  # when it was recorded, ns
    content: Any


class Bag(NamedTuple):
    """An open file."""

    topics: Mapping[str, str]  # types of the messages, by topic
    messages: Callable[[Collection[str]], Iterator[Message]]  # of some topics, in the order of `logged`


class Named(NamedTuple):
    """An entry of a list that is given by its name."""

    name: str


Part = str | int | Named


class _LackingError(Exception):
    """A message has no entry of a name; those that it has."""

    def __init__(self, names: list[str]):
        super().__init__(names)
        self.names = names


class Column(NamedTuple):
    """A field of the messages of a topic."""

    name: str
    topic: str
    path: tuple[Part, ...]

    @property
    def key(self) -> Named | None:
        """The name of the entry of a list in it."""
        return next((part for part in self.path if isinstance(part, Named)), None)


@dataclass
class Series:
    """The messages of a topic that have an entry of a name, as far as columns need them."""

    columns: list[Column] = field(default_factory=list)
    clock: list[int] = field(default_factory=list)  # ns
    values: list[list[float]] = field(default_factory=list)
    is_clock: bool = False  # whether the time is a stamp or `log_time`
    lacking: int = 0  # messages without that entry
    other_names: set[str] = field(default_factory=set)  # of entries, in these
    entries: dict[str, str] = field(default_factory=dict)  # names of entries that are given by their place, by column
    spans: dict[str, tuple[int, int]] = field(default_factory=dict)  # ns, by publisher and frame


def bag_columns(path: Path, time: str, columns: Iterable[str], hold: float, unit: float) -> Array:
    """Columns of numbers, (T, 1 + len(columns)), the time first.

    Args:
        path: a ROS 1 bag, the folder or the database of a ROS 2 bag, or an MCAP file.
        time: column whose topic gives the rows; a stamp is counted from the first row.
        columns: other columns; NaN in rows for which there is none.
        hold: age, s, up to which a message of one topic is used in the rows of another.
        unit: of a stamp in the table, s.

    Raises:
        InputError: if there is no such topic or field, or it has several meanings.
    """
    with ExitStack() as stack:
        bag = (_mcap if path.suffix == ".mcap" else _ros_bag)(path, stack)
        rows_of, *others = (_column(path, name, bag.topics) for name in (time, *columns))
        keys = [column.key for column in others if column.topic == rows_of.topic]
        key = rows_of.key or (keys[0] if keys and None not in keys else None)
        series = {(rows_of.topic, key): Series([rows_of])}
        for column in others:
            series.setdefault((column.topic, column.key), Series()).columns.append(column)
        _read(path, bag, series, rows_of)
    for each in series.values():
        _check_meaning(path, each, each.columns[0].name)
    rows = series.pop((rows_of.topic, key))
    if not rows.clock:
        raise InputError(path, "column", time, "there are no messages of this topic")
    if rows.lacking and key is not None:
        every = rows.lacking + len(rows.clock)
        note(LEFT_OUT, path, f"{rows.lacking} of {every} messages of {rows_of.topic}", "", f"they lack '{key.name}'")
    if rows.is_clock:
        _sort(path, rows)
    values = np.array(rows.values, dtype=float)
    found = {column.name: values[:, i] for i, column in enumerate(rows.columns)}
    if rows.is_clock:
        found[rows_of.name] = np.array([at - rows.clock[0] for at in rows.clock]) / (_SECOND * unit)
    for each in series.values():
        held = _held(each, rows.clock, hold)
        found |= {column.name: held[:, i] for i, column in enumerate(each.columns)}
    return np.column_stack([found[column.name] for column in (rows_of, *others)])


def _read(path: Path, bag: Bag, series: Mapping[tuple[str, Named | None], Series], rows_of: Column) -> None:
    """Fills the series."""
    for message in bag.messages({topic for topic, _ in series}):
        for (topic, key), each in series.items():
            if topic != message.topic:
                continue
            try:
                values = [_number(path, column, message, each) for column in each.columns]
            except _LackingError as error:
                each.lacking += 1
                each.other_names.update(error.names[:_MOST_SHOWN])
                continue
            stamp = _stamp_at(
                message.content, [key if key and isinstance(part, Named) else part for part in rows_of.path]
            )
            each.is_clock = stamp is not None or rows_of.path == _LOGGED
            each.clock.append(message.logged if stamp is None else stamp)
            each.values.append(values)
            if key is None:
                origin = f"{message.publisher} {_frame(message.content)}".strip()
                first, _ = each.spans.setdefault(origin, (message.logged, message.logged))
                each.spans[origin] = first, message.logged


def _check_meaning(path: Path, series: Series, name: str) -> None:
    """Raises an InputError if no message has an entry of a name, or those of several publishers are mixed."""
    if series.lacking and not series.clock:
        raise InputError(path, "column", name, f"no message has it; named are: {_listed(sorted(series.other_names))}")
    spans = sorted((span, origin) for origin, span in series.spans.items())
    for ((_, ended), one), ((begun, _), other) in pairwise(spans):
        if begun < ended:
            expected = f"its messages are mixed, of '{one}' and '{other}': filter the bag, so that it has those of one"
            raise InputError(path, "column", name, expected)


def _sort(path: Path, rows: Series) -> None:
    """Sorts rows by their stamps, which may be a little late; those of another recording are left where they are."""
    clock = np.array(rows.clock)
    late = np.maximum.accumulate(clock) - clock
    if 0 < late.max() <= _MOST_LATE:
        order = np.argsort(clock, kind="stable")
        rows.clock, rows.values = clock[order].tolist(), [rows.values[i] for i in order]
        why = f"their stamps are up to {1e-6 * late.max():.3g} ms earlier than one before: rows are sorted by them"
        note(MENDED, path, f"{np.count_nonzero(late)} of {len(clock)} messages", "", why)


def _held(series: Series, rows: list[int], hold: float) -> Array:
    """The values of each row, (T, columns)."""
    values = np.array(series.values, dtype=float).reshape(len(series.clock), len(series.columns))
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
    parts = re.findall(r"[^.\[\]]+|\[[^\[\]]*\]", name[len(topic) + 1 :])
    return Column(name, topic, tuple(_entry(part[1:-1]) if part[0] == "[" else part for part in parts))


def _entry(text: str) -> int | Named:
    return int(text) if text.isascii() and text.isdecimal() and len(text) <= _MOST_DIGITS else Named(text)


def _number(path: Path, column: Column, message: Message, series: Series) -> float:
    """A number of a message; NaN where there is none, s of stamps.

    Raises:
        _LackingError: if it has no entry of the name.
    """
    if column.path == _LOGGED:
        return message.logged / _SECOND
    try:
        value, entry = _at(message.content, column.path)
    except IndexError:
        return np.nan  # a list may be shorter in some messages
    except (LookupError, AttributeError, TypeError):
        raise _unknown(path, column, message.content) from None
    if series.entries.setdefault(column.name, entry) != entry:
        known = series.entries[column.name]
        expected = f"is '{known}' in some messages and '{entry}' in others: give the name in the place of the number"
        raise InputError(path, "column", column.name, expected)
    if (stamp := _stamp(value)) is not None:
        return stamp / _SECOND
    if value is None:
        return np.nan
    if isinstance(value, bool | int | float | np.number | np.bool_):
        return float(value)
    raise _unknown(path, column, message.content)


def _unknown(path: Path, column: Column, message: Any) -> InputError:
    known = _listed([*_leaves(message), *_LOGGED])
    return InputError(path, "column", column.name, f"is not a number of {column.topic}, which has: {known}")


def _at(message: Any, path: Iterable[Part]) -> tuple[Any, str]:
    """A part of a message, and the name of the entry of a list in it that is given by its place; "" if it has none."""
    beside, entry = message, ""
    for part in path:
        if isinstance(part, str):
            beside, message = message, _field(message, part)
            continue
        names = _entry_names(message, beside)
        if isinstance(part, Named):
            if names is None:
                raise LookupError(part.name)
            if part.name not in names:
                raise _LackingError(names)
            message = message[names.index(part.name)]
        else:
            message = message[part]
            entry = names[part] if names else ""
    return message, entry


def _field(message: Any, name: str) -> Any:
    return message[name] if isinstance(message, dict) else getattr(message, name)


def _entry_names(entries: Any, beside: Any) -> list[str] | None:
    """The names of the entries of a list: their own, or those in a list beside it; None if they have none."""
    own = next((name for name in _OWN_NAMES if len(entries) and _has(entries[0], name)), None)
    if own is not None:
        return [str(_field(entry, own)) for entry in entries]
    lists = (_field(beside, name) for name in _NAMES if _has(beside, name))
    return next(([*map(str, names)] for names in lists if isinstance(names, list)), None if len(entries) else [])


def _has(message: Any, name: str) -> bool:
    return name in message if isinstance(message, dict) else hasattr(message, name)


def _frame(message: Any) -> str:
    """The frame of a message with a header."""
    try:
        return str(_field(_field(message, "header"), "frame_id"))
    except (LookupError, AttributeError, TypeError):
        return ""


def _stamp_at(message: Any, path: Iterable[Part]) -> int | None:
    try:
        return _stamp(_at(message, path)[0])
    except (LookupError, AttributeError, TypeError, _LackingError):
        return None


def _stamp(value: Any) -> int | None:
    """A time in ns, of ROS or of JSON; None if it is none."""
    parts = value if isinstance(value, dict) else getattr(value, "__dict__", {})
    nanoseconds = parts.get("nanosec", parts.get("nsec"))
    if nanoseconds is None or "sec" not in parts:
        return None
    whole, rest = (int(number(str(part))) for part in (parts["sec"], nanoseconds))  # JSON has them as text, too
    return whole * _SECOND + rest


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

    def messages(topics: Collection[str]) -> Iterator[Message]:
        chosen = [each for each in reader.connections if each.topic in topics]
        for connection, logged, data in reader.messages(chosen):
            publisher = getattr(connection.ext, "callerid", None) or ""  # known in ROS 1
            yield Message(connection.topic, publisher, logged, reader.deserialize(data, connection.msgtype))

    return Bag({each.topic: each.msgtype for each in reader.connections}, messages)


def _mcap(path: Path, stack: ExitStack) -> Bag:
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    reader = make_reader(stack.enter_context(path.open("rb")), validate_crcs=True)
    store, registered = get_typestore(Stores.EMPTY), set[str]()

    def decoded(schema: Any, channel: Any, data: bytes) -> Any:
        if channel.message_encoding == "json":
            return parse_json(path, data, finite=False)
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

    def messages(topics: Collection[str]) -> Iterator[Message]:
        for schema, channel, message in reader.iter_messages(topics=list(topics)):
            content = decoded(schema, channel, message.data)
            yield Message(channel.topic, f"channel {channel.id}", message.log_time, content)

    summary = reader.get_summary()
    if summary is None:
        raise InputError(path, "file", path.name, "was not closed: it has no index; repair it with `mcap recover`")
    schemas = {number: schema.name for number, schema in summary.schemas.items()}
    return Bag({each.topic: schemas.get(each.schema_id, "") for each in summary.channels.values()}, messages)
