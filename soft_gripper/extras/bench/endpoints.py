"""Where messages come from and go to, by address.

| address | what it is |
|---|---|
| `udp://HOST:PORT` | datagrams; without HOST those of this machine alone; port 0 takes a free one |
| `serial:///dev/ttyACM0?baud=115200` | lines over a serial port (`pip install 'soft-gripper[live]'`) |
| `stdio:` | lines of standard input and output |
| `file:readings.csv` | lines of a file, at the rate of the sensors, or of a pipe; results overwrite a file |
| `file:readings.mcap` | rows of a bag, of netCDF or of a C3D file, see `tables`; the time gives the rows |
| `MODULE:FUNCTION` | a generator of messages in Python, or a function that takes each result |
"""

import os
import selectors
import socket
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import IO, Any, Protocol
from urllib.parse import SplitResult, parse_qs, unquote, urlsplit

from soft_gripper.errors import InputError
from soft_gripper.extras.bench.messages import MOST_BYTES
from soft_gripper.extras.bench.threads import ROOM, Inbox, Message, Outbox, write_all
from soft_gripper.extras.hardware.table import Columns
from soft_gripper.extras.hardware.table_files import OTHER_THAN_TEXT, is_bag_folder, read_table
from soft_gripper.files.document import require_value
from soft_gripper.files.text import check_regular
from soft_gripper.registry import OWN, blamed_on

MOST_WAITING = 4096  # messages that are read at once
LOOPBACK = "127.0.0.1"
_RECEIVE_BUFFER = 2**20  # bytes; the operating system may grant less
_BAUD = 115200

Sink = Callable[[bytes, dict[str, Any]], None]  # takes a message, encoded and by name; does not wait


class Source(Protocol):
    """Where readings come from."""

    @property
    def is_over(self) -> bool:
        """Whether nothing will ever arrive again."""

    def receive(self, timeout: float) -> list[Message]:
        """Messages that have arrived, MOST_WAITING at most; waits up to `timeout` s for the first."""


class Endpoints:
    """Opens addresses, and closes everything at the end of a `with` block; a serial port serves both ways."""

    def __init__(self, where: Path | str, until: Callable[[], bool] | None = None):
        """
        Args:
            where: the file that gives the addresses, for messages.
            until: if given, results wait for whoever takes them until this is true; otherwise they are dropped.
        """
        self._where, self._until, self._stack = where, until, ExitStack()
        self._outboxes: list[Outbox[Any]] = []
        self._ports: dict[str, Any] = {}  # serial ports, by name

    def __enter__(self) -> "Endpoints":
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def dropped(self) -> int:
        """Results that nobody took in time."""
        return sum(outbox.dropped for outbox in self._outboxes)

    def source(self, address: str, period: float = 0.0, columns: Columns | None = None) -> Source:
        """Where readings come from; the lines of a file come every `period` s.

        Args:
            address: one of those above.
            period: between the messages of a file or a generator, s; 0 for as fast as possible.
            columns: that are needed of a file that is not text; None: there is no column of the time.

        Raises:
            InputError: if it cannot be opened.
        """
        parts = urlsplit(address)
        open_one: dict[str, Callable[[], Source]] = {
            "udp": lambda: UdpSource(self._bound(parts)),
            "serial": lambda: LineSource(self._serial(parts).fileno()),
            "stdio": lambda: LineSource(sys.stdin.fileno()),
            "file": lambda: self._file_source(parts, columns, period),
        }
        found: Source | None = self._opened("source", address, open_one)
        if found is not None:
            return found
        return Inbox(self._own_messages(address, OWN.find(address, "source", self._where)), period)

    def sink(self, address: str) -> Sink:
        """Where results go.

        Raises:
            InputError: if it cannot be opened.
        """
        parts = urlsplit(address)
        open_one: dict[str, Callable[[], Sink]] = {
            "udp": lambda: self._udp_sink(parts),
            "serial": lambda: self.patient(writer(self._serial(parts).fileno()), room=1),
            "stdio": lambda: self.patient(print_out),
            "file": lambda: self.patient(self._file_writer(file_path(parts))),
        }
        found: Sink | None = self._opened("sink", address, open_one)
        return found or self.patient(self._own_sink(address), room=1)

    def patient(self, take: Sink, room: int = ROOM) -> Sink:
        """Non-blocking wrapper of a sink; what commands a device has room for the newest result alone."""
        outbox = Outbox[tuple[bytes, dict[str, Any]]](lambda sent: take(*sent), self._until, room)
        self._outboxes.append(outbox)
        self._stack.callback(outbox.close)
        return lambda message, results: outbox.put((message, results))

    def _own_messages(self, address: str, messages: Callable[[], Iterable[Message]]) -> Iterator[Message]:
        """Messages of a user's generator, whose errors name it."""
        with blamed_on("source", address, self._where):
            yield from messages()

    def _own_sink(self, address: str) -> Sink:
        function = OWN.find(address, "sink", self._where)

        def take(_: bytes, results: dict[str, Any]) -> None:
            with blamed_on("sink", address, self._where):
                function(results)

        return take

    def _opened(self, field: str, address: str, known: Mapping[str, Callable[[], Any]]) -> Any:
        """The end that an address names; None if it is a user's function."""
        scheme, colon, rest = address.partition(":")
        if not colon or (scheme not in known and rest.startswith("/")):
            expected = f"give an address that begins with {', '.join(f'{name}:' for name in known)}, or module:function"
            raise InputError(self._where, field, address, expected)
        try:
            return known[scheme]() if scheme in known else None
        except InputError:
            raise
        except (OSError, ValueError, RuntimeError, OverflowError) as error:  # the last of a baud rate
            reason = getattr(error, "strerror", None) or error
            raise InputError(self._where, field, address, f"cannot be opened: {reason}") from error

    def _bound(self, parts: SplitResult) -> socket.socket:
        found = self._stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        found.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        found.bind(_place(parts))
        found.setblocking(False)
        return found

    def _udp_sink(self, parts: SplitResult) -> Sink:
        sender = self._stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        sender.setblocking(False)
        place = _place(parts)

        def send(message: bytes, _: dict[str, Any]) -> None:
            with suppress(OSError):  # nobody listens, or the network is busy: datagrams may be lost
                sender.sendto(message, place)

        return send

    def _serial(self, parts: SplitResult) -> Any:
        try:
            from serial import Serial
        except ImportError:
            expected = "requires pyserial: pip install 'soft-gripper[live]'"
            raise InputError(self._where, "source", parts.geturl(), expected) from None
        name, baud = unquote(parts.path), int(parse_qs(parts.query).get("baud", [str(_BAUD)])[0])
        if name not in self._ports:
            self._ports[name] = self._stack.enter_context(Serial(name, baud, timeout=0))
        return self._ports[name]

    def _file_source(self, parts: SplitResult, columns: Columns | None, period: float) -> "Source":
        path = file_path(parts)
        if path.exists() and not path.is_file() and not path.is_dir():  # a pipe or device, which may wait
            descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
            self._stack.callback(os.close, descriptor)
            return LineSource(descriptor)
        return PacedSource(self._messages(path, columns), period)

    def _file_writer(self, path: Path) -> Sink:
        """A pipe is opened when the first result is written: that waits for whoever reads it."""
        if path.is_fifo():
            opened: list[int] = []

            def write(message: bytes, _: dict[str, Any]) -> None:
                if not opened:
                    opened.append(os.open(path, os.O_WRONLY))
                write_all(opened[0], message)

            return write
        return writer(self._stack.enter_context(path.open("wb", buffering=0)).fileno())

    def _messages(self, path: Path, columns: Columns | None) -> Iterator[Message]:
        """The lines of a file, names in its first line passed over; or the rows of another kind of file."""
        if is_bag_folder(path) or path.suffix.lower() in OTHER_THAN_TEXT:
            table = read_table(
                path, require_value(columns, self._where, "time", "name the column that has the time of each row")
            )
            return (dict(zip(table.names, row, strict=True)) for row in table.values.tolist())
        file = self._stack.enter_context(path.open("rb"))
        check_regular(path)
        lines = enumerate(line for line in _lines(path, file) if line.strip())
        return (line for number, line in lines if number or line.lstrip()[:1] in b"{+-.0123456789")


def _lines(path: Path, file: IO[bytes]) -> Iterator[bytes]:
    for number, line in enumerate(iter(lambda: file.readline(MOST_BYTES + 1), b""), 1):
        if len(line) > MOST_BYTES:
            raise InputError(path, "line", number, f"has more than {MOST_BYTES} bytes; give a reading a line")
        yield line


_Selector = getattr(selectors, "PollSelector", selectors.SelectSelector)  # epoll refuses files on a disk


def _has_come(file: socket.socket | int, timeout: float) -> bool:
    """Whether there is something to read from a socket or descriptor, of any number, within a timeout, s."""
    with _Selector() as selector:
        selector.register(file, selectors.EVENT_READ)
        return bool(selector.select(timeout))


class UdpSource:
    """The datagrams that arrive at a socket."""

    is_over = False

    def __init__(self, bound: socket.socket):
        self._socket = bound
        self.host, self.port = bound.getsockname()

    def receive(self, timeout: float) -> list[Message]:
        if not _has_come(self._socket, timeout):
            return []
        found: list[Message] = []
        while len(found) < MOST_WAITING:
            try:
                found.append(self._socket.recv(MOST_BYTES + 1))
            except BlockingIOError:
                break
        return found


class LineSource:
    """The lines that can be read from a file descriptor, such as a serial port."""

    def __init__(self, descriptor: int):
        self._descriptor, self._begun, self.is_over = descriptor, b"", False
        self._is_cut = False  # the line that has begun is the rest of one that was too long

    def receive(self, timeout: float) -> list[Message]:
        if self.is_over or not _has_come(self._descriptor, timeout):
            return []
        try:
            arrived = os.read(self._descriptor, MOST_BYTES)
        except BlockingIOError:
            return []
        except OSError:  # unplugged
            arrived = b""
        self.is_over = not arrived
        *lines, self._begun = (self._begun + arrived).split(b"\n")
        if self._is_cut:
            self._begun, self._is_cut = self._begun if lines else b"", not lines
            lines = lines[1:]
        if len(self._begun) > MOST_BYTES:  # no line is that long: it is passed on, and counted
            lines, self._begun, self._is_cut = [*lines, self._begun], b"", True
        return [line for line in lines if line.strip()]


class PacedSource:
    """Messages of a file or of a generator, one every period; with period 0 one whenever it is asked for."""

    def __init__(self, messages: Iterable[Message], period: float):
        self._messages, self._period, self.is_over = iter(messages), period, False
        self._due = time.monotonic()

    def receive(self, timeout: float) -> list[Message]:
        early = self._due - time.monotonic()
        if self._period and early > 0:
            time.sleep(min(early, timeout))
            if early > timeout:
                return []
        self._due += self._period
        for message in self._messages:
            return [message]
        self.is_over = True
        return []


def _place(parts: SplitResult) -> tuple[str, int]:
    if parts.port is None:
        raise ValueError("give a port, as in udp://127.0.0.1:5005")
    return parts.hostname or LOOPBACK, parts.port


def file_path(parts: SplitResult) -> Path:
    """The file that an address names."""
    return Path(unquote(f"{parts.netloc}{parts.path}"))


def writer(descriptor: int) -> Sink:
    """Writes messages to a file descriptor; waits for room."""
    return lambda message, _: write_all(descriptor, message)


def print_out(message: bytes, _: dict[str, Any]) -> None:
    """Writes a message to standard output; waits for room."""
    try:
        descriptor = sys.stdout.fileno()
    except (AttributeError, OSError):  # it is no file, but stands in for one
        sys.stdout.write(message.decode())
    else:  # past Python's buffer, whose lock would be held while nobody reads
        write_all(descriptor, message)
