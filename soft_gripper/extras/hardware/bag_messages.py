"""Messages of ROS 1 bags, ROS 2 bags and MCAP files (https://mcap.dev) -> columns of numbers.

A column is a topic and a field of its messages, such as `/joint_states.position[2]`; a time stamp, `header.stamp`, is
in seconds, and `log_time` is the time of recording. An entry of a list is named by its index or by its name,
`/joint_states.position[wrist]`, `/tf.transforms[tip].transform.translation.x`; one that has another name in other
messages must be named so. The messages of one topic, that of the time, are the rows. Of every other topic, a row has
the last message up to it, unless that is too old. Messages that lack an entry of the name are skipped.
Messages are ordered by their stamp, or by the time of recording if they have none.

It runs in a process of its own (`isolated_reading`), which imports the libraries of bags. Another file format needs a
function such as `_mcap`, which gives its topics and messages.
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

_LOG_TIME_PATH = ("log_time",)
_NS_PER_S = 10**9  # ns
_MAX_LATENESS = 10**9  # ns; a message may be stamped before another that was recorded earlier
_MAX_INDEX_DIGITS = 9  # digits of the index of an entry
_MAX_NAMES_SHOWN = 30  # topics or fields in a message
_NAME_LIST_FIELDS = "name", "names", "joint_names"  # fields with the names of the entries of the lists beside them
_NAME_FIELDS = "child_frame_id", "name"  # fields with the name of an entry


class Message(NamedTuple):
    """A message and its origin."""

    topic: str
    publisher: str
    logged: int  # time of recording, ns
    content: Any


class Bag(NamedTuple):
    """An open file."""

    topics: Mapping[str, str]  # types of the messages, by topic
    messages: Callable[[Collection[str]], Iterator[Message]]  # of some topics, in the order of `logged`


class EntryName(NamedTuple):
    """Name of an entry of a list."""

    name: str


Part = str | int | EntryName


class _MissingEntryError(Exception):
    """A message has no entry of a name; its entries have these names."""

    def __init__(self, names: list[str]):
        super().__init__(names)
        self.names = names


class Column(NamedTuple):
    """A number in the messages of a topic."""

    name: str
    topic: str
    path: tuple[Part, ...]

    @property
    def key(self) -> EntryName | None:
        """Name of the list entry in the path of the column."""
        return next((part for part in self.path if isinstance(part, EntryName)), None)


@dataclass
class Series:
    """Needed numbers of the messages of a topic that have an entry of a name."""

    columns: list[Column] = field(default_factory=list)
    clock: list[int] = field(default_factory=list)  # ns
    values: list[list[float]] = field(default_factory=list)
    is_clock: bool = False  # whether the time is a stamp or `log_time`
    lacking: int = 0  # messages without that entry
    other_names: set[str] = field(default_factory=set)  # of entries in those messages
    entries: dict[str, str] = field(default_factory=dict)  # names of entries that are given by their index, by column
    spans: dict[str, tuple[int, int]] = field(default_factory=dict)  # ns, by publisher and frame


def bag_columns(path: Path, time: str, columns: Iterable[str], hold: float, unit: float) -> Array:
    """Columns of numbers, (T, 1 + len(columns)), the time first.

    Args:
        path: a ROS 1 bag, the folder or the database of a ROS 2 bag, or an MCAP file.
        time: column whose topic gives the rows; a stamp is counted from the first row.
        columns: other columns; NaN in rows for which there is none.
        hold: age, s, up to which a message of one topic is used in the rows of another.
        unit: of a stamp in the table, s.
    """
    with ExitStack() as stack:
        bag = (_mcap if path.suffix == ".mcap" else _ros_bag)(path, stack)
        clock, *other_columns = (_column(path, name, bag.topics) for name in (time, *columns))
        keys = [column.key for column in other_columns if column.topic == clock.topic]
        key = clock.key or (keys[0] if keys and None not in keys else None)
        series = {(clock.topic, key): Series([clock])}
        for column in other_columns:
            series.setdefault((column.topic, column.key), Series()).columns.append(column)
        _read(path, bag, series, clock)
    for entry in series.values():
        _check_meaning(path, entry, entry.columns[0].name)
    rows = series.pop((clock.topic, key))
    if not rows.clock:
        raise InputError(path, "column", time, "there are no messages of this topic")
    if rows.lacking and key is not None:
        total = rows.lacking + len(rows.clock)
        note(LEFT_OUT, path, f"{rows.lacking} of {total} messages of {clock.topic}", "", f"they lack '{key.name}'")
    if rows.is_clock:
        _sort(path, rows)
    values = np.array(rows.values, dtype=float)
    named_columns = {column.name: values[:, i] for i, column in enumerate(rows.columns)}
    if rows.is_clock:
        named_columns[clock.name] = np.array([stamp - rows.clock[0] for stamp in rows.clock]) / (_NS_PER_S * unit)
    for entry in series.values():
        row_values = _row_values(entry, rows.clock, hold)
        named_columns |= {column.name: row_values[:, i] for i, column in enumerate(entry.columns)}
    return np.column_stack([named_columns[column.name] for column in (clock, *other_columns)])


def _read(path: Path, bag: Bag, series: Mapping[tuple[str, EntryName | None], Series], clock: Column) -> None:
    """Reads all messages into the series."""
    for message in bag.messages({topic for topic, _ in series}):
        for (topic, key), entry in series.items():
            if topic != message.topic:
                continue
            try:
                values = [_number(path, column, message, entry) for column in entry.columns]
            except _MissingEntryError as error:
                entry.lacking += 1
                entry.other_names.update(error.names[:_MAX_NAMES_SHOWN])
                continue
            stamp = _find_stamp(
                message.content, [key if key and isinstance(part, EntryName) else part for part in clock.path]
            )
            entry.is_clock = stamp is not None or clock.path == _LOG_TIME_PATH
            entry.clock.append(message.logged if stamp is None else stamp)
            entry.values.append(values)
            if key is None:
                origin = f"{message.publisher} {_frame(message.content)}".strip()
                first, _ = entry.spans.setdefault(origin, (message.logged, message.logged))
                entry.spans[origin] = first, message.logged


def _check_meaning(path: Path, series: Series, name: str) -> None:
    """Raises an InputError if no message has an entry of a name, or those of several publishers are mixed."""
    if series.lacking and not series.clock:
        raise InputError(path, "column", name, f"no message has it; named are: {_shorten(sorted(series.other_names))}")
    spans = sorted((span, origin) for origin, span in series.spans.items())
    for ((_, end_time), first), ((begin_time, _), second) in pairwise(spans):
        if begin_time < end_time:
            expected = f"its messages are mixed, of '{first}' and '{second}': filter the bag to have those of one"
            raise InputError(path, "column", name, expected)


def _sort(path: Path, rows: Series) -> None:
    """Sorts rows whose stamps are a little late; rows of another recording keep their places."""
    clock = np.array(rows.clock)
    delays = np.maximum.accumulate(clock) - clock
    if 0 < delays.max() <= _MAX_LATENESS:
        order = np.argsort(clock, kind="stable")
        rows.clock, rows.values = clock[order].tolist(), [rows.values[i] for i in order]
        reason = f"their stamps are up to {1e-6 * delays.max():.3g} ms earlier than one before: rows are sorted by them"
        note(MENDED, path, f"{np.count_nonzero(delays)} of {len(clock)} messages", "", reason)


def _row_values(series: Series, rows: list[int], hold: float) -> Array:
    """Values of each row, (T, columns)."""
    values = np.array(series.values, dtype=float).reshape(len(series.clock), len(series.columns))
    order = np.argsort(series.clock, kind="stable")
    clock = [series.clock[i] for i in order]
    row_values = np.full((len(rows), len(series.columns)), np.nan)
    for row, stamp in enumerate(rows):
        last = bisect_right(clock, stamp) - 1
        if last >= 0 and stamp - clock[last] <= hold * _NS_PER_S:
            row_values[row] = values[order[last]]
    return row_values


def _column(path: Path, name: str, topics: Mapping[str, str]) -> Column:
    topic = max((topic for topic in topics if name.startswith(f"{topic}.")), key=len, default=None)
    if topic is None:
        listing = _shorten(f"{topic} ({kind})" for topic, kind in sorted(topics.items()))
        expected = f"give a topic and a field, as in /topic.field[0]; the topics of the file: {listing}"
        raise InputError(path, "column", name, expected)
    parts = re.findall(r"[^.\[\]]+|\[[^\[\]]*\]", name[len(topic) + 1 :])
    return Column(name, topic, tuple(_entry(part[1:-1]) if part[0] == "[" else part for part in parts))


def _entry(text: str) -> int | EntryName:
    return int(text) if text.isascii() and text.isdecimal() and len(text) <= _MAX_INDEX_DIGITS else EntryName(text)


def _number(path: Path, column: Column, message: Message, series: Series) -> float:
    """A number of a message; NaN where there is none, s of stamps.

    Raises:
        _MissingEntryError: if it has no entry of the name.
    """
    if column.path == _LOG_TIME_PATH:
        return message.logged / _NS_PER_S
    try:
        value, entry = _resolve(message.content, column.path)
    except IndexError:
        return np.nan  # a list may be shorter in some messages
    except (LookupError, AttributeError, TypeError):
        raise _number_error(path, column, message.content) from None
    if series.entries.setdefault(column.name, entry) != entry:
        entry_name = series.entries[column.name]
        expected = f"is '{entry_name}' in some messages and '{entry}' in others: give the name instead of the number"
        raise InputError(path, "column", column.name, expected)
    if (stamp := _stamp(value)) is not None:
        return stamp / _NS_PER_S
    if value is None:
        return np.nan
    if isinstance(value, bool | int | float | np.number | np.bool_):
        return float(value)
    raise _number_error(path, column, message.content)


def _number_error(path: Path, column: Column, message: Any) -> InputError:
    listing = _shorten([*_leaves(message), *_LOG_TIME_PATH])
    return InputError(path, "column", column.name, f"is not a number of {column.topic}, which has: {listing}")


def _resolve(message: Any, path: Iterable[Part]) -> tuple[Any, str]:
    """Part of a message, and the name of a list entry given by its index; "" if it has no name."""
    parent, entry = message, ""
    for part in path:
        if isinstance(part, str):
            parent, message = message, _field(message, part)
            continue
        names = _entry_names(message, parent)
        if isinstance(part, EntryName):
            if names is None:
                raise LookupError(part.name)
            if part.name not in names:
                raise _MissingEntryError(names)
            message = message[names.index(part.name)]
        else:
            message = message[part]
            entry = names[part] if names else ""
    return message, entry


def _field(message: Any, name: str) -> Any:
    return message[name] if isinstance(message, dict) else getattr(message, name)


def _entry_names(entries: Any, parent: Any) -> list[str] | None:
    """Names of the entries of a list, from the entries or from a list beside it; None: they have none."""
    name_field = next((name for name in _NAME_FIELDS if len(entries) and _has_entry(entries[0], name)), None)
    if name_field is not None:
        return [str(_field(entry, name_field)) for entry in entries]
    lists = (_field(parent, name) for name in _NAME_LIST_FIELDS if _has_entry(parent, name))
    return next(([*map(str, names)] for names in lists if isinstance(names, list)), None if len(entries) else [])


def _has_entry(message: Any, name: str) -> bool:
    return name in message if isinstance(message, dict) else hasattr(message, name)


def _frame(message: Any) -> str:
    """The frame of a message with a header."""
    try:
        return str(_field(_field(message, "header"), "frame_id"))
    except (LookupError, AttributeError, TypeError):
        return ""


def _find_stamp(message: Any, path: Iterable[Part]) -> int | None:
    try:
        return _stamp(_resolve(message, path)[0])
    except (LookupError, AttributeError, TypeError, _MissingEntryError):
        return None


def _stamp(value: Any) -> int | None:
    """Time of ROS or JSON, ns; None if a value is no time."""
    entries = value if isinstance(value, dict) else getattr(value, "__dict__", {})
    nanoseconds = entries.get("nanosec", entries.get("nsec"))
    if nanoseconds is None or "sec" not in entries:
        return None
    seconds, fraction = (int(number(str(text))) for text in (entries["sec"], nanoseconds))  # JSON has them as text, too
    return seconds * _NS_PER_S + fraction


def _leaves(value: Any, name: str = "") -> Iterator[str]:
    """The numbers and texts in a message, as columns name them; `[0..3]` stands for four entries."""
    if isinstance(value, dict):
        parts = value
    elif is_dataclass(value):
        parts = {item.name: getattr(value, item.name) for item in fields(value) if not item.name.startswith("__")}
    elif isinstance(value, list | tuple | np.ndarray) and len(value):
        yield from _leaves(value[0], f"{name}[0..{len(value) - 1}]")
        return
    else:
        yield name if not isinstance(value, str) else f"{name} (text)"
        return
    for key, entry in parts.items():
        yield from _leaves(entry, f"{name}.{key}" if name else str(key))


def _shorten(names: Iterable[str]) -> str:
    all_names = list(names)
    return ", ".join([*all_names[:_MAX_NAMES_SHOWN], *(["..."] if len(all_names) > _MAX_NAMES_SHOWN else [])]) or "none"


def _ros_bag(path: Path, stack: ExitStack) -> Bag:
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    # Databases of older versions of ROS 2 do not define their messages.
    reader = stack.enter_context(AnyReader([path], default_typestore=get_typestore(Stores.LATEST)))

    def messages(topics: Collection[str]) -> Iterator[Message]:
        read_connections = [connection for connection in reader.connections if connection.topic in topics]
        for connection, log_time, data in reader.messages(read_connections):
            publisher = getattr(connection.ext, "callerid", None) or ""  # known in ROS 1
            yield Message(connection.topic, publisher, log_time, reader.deserialize(data, connection.msgtype))

    return Bag({connection.topic: connection.msgtype for connection in reader.connections}, messages)


def _mcap(path: Path, stack: ExitStack) -> Bag:
    from mcap.reader import make_reader
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    reader = make_reader(stack.enter_context(path.open("rb")), validate_crcs=True)
    store, registered = get_typestore(Stores.EMPTY), set[str]()

    def decode(schema: Any, channel: Any, data: bytes) -> Any:
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
            content = decode(schema, channel, message.data)
            yield Message(channel.topic, f"channel {channel.id}", message.log_time, content)

    summary = reader.get_summary()
    if summary is None:
        raise InputError(path, "file", path.name, "was not closed: it has no index; repair it with `mcap recover`")
    schemas = {number: schema.name for number, schema in summary.schemas.items()}
    return Bag({channel.topic: schemas.get(channel.schema_id, "") for channel in summary.channels.values()}, messages)
