"""Opens the sources and sinks of messages, by address.

| address | messages |
|---|---|
| `udp://HOST:PORT` | datagrams; without HOST those of this machine alone; port 0 takes a free one |
| `serial:///dev/ttyACM0?baud=115200` | lines over a serial port (`pip install 'soft-gripper[live]'`) |
| `stdio:` | lines of standard input and output |
| `file:readings.csv` | lines of a file, at the rate of the sensors, or of a pipe; results overwrite a file |
| `file:readings.mcap` | rows of a bag, of netCDF or of a C3D file, see `tables`; the time gives the rows |
| `MODULE:FUNCTION` | a generator of messages in Python, or a function that takes each result |

Another scheme is an entry of `openers` in `Endpoints.source` or `Endpoints.sink`.
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
from soft_gripper.extras.bench.messages import MAX_MESSAGE_BYTES
from soft_gripper.extras.bench.threads import ROOM, Inbox, Message, Outbox, write_all
from soft_gripper.extras.hardware.table import Columns
from soft_gripper.extras.hardware.table_files import OTHER_THAN_TEXT, is_bag_folder, read_table
from soft_gripper.files.document import require_value
from soft_gripper.files.text import check_regular
from soft_gripper.registry import OWN, blamed_on

MAX_WAITING = 4096  # maximum of messages read at once
LOOPBACK = "127.0.0.1"
_RECEIVE_BUFFER = 2**20  # bytes; the operating system may grant less
_BAUD_RATE = 115200

Sink = Callable[[bytes, dict[str, Any]], None]  # takes a message, encoded and by name; does not wait


class Source(Protocol):
    """A source of readings."""

    @property
    def is_over(self) -> bool:
        """Whether the source has ended."""

    def receive(self, timeout: float) -> list[Message]:
        """Messages that have arrived, MAX_WAITING at most; waits up to `timeout` s for the first."""


class Endpoints:
    """Opens addresses, and closes everything at the end of a `with` block; a serial port serves both ways."""

    def __init__(self, where: Path | str, until: Callable[[], bool] | None = None):
        """
        Args:
            where: the file with the addresses, for error messages.
            until: if given, results wait for their readers until this is true; otherwise they are dropped.
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
        """Number of results that were not read in time."""
        return sum(outbox.dropped for outbox in self._outboxes)

    def source(self, address: str, period: float = 0.0, columns: Columns | None = None) -> Source:
        """Opens a source of readings; the lines of a file come every `period` s.

        Args:
            address: one of those above.
            period: between the messages of a file or a generator, s; 0 for as fast as possible.
            columns: needed of a file that is not text; None: there is no column of the time.

        Raises:
            InputError: if it cannot be opened.
        """
        parts = urlsplit(address)
        openers: dict[str, Callable[[], Source]] = {
            "udp": lambda: UdpSource(self._bind(parts)),
            "serial": lambda: LineSource(self._serial(parts).fileno()),
            "stdio": lambda: LineSource(sys.stdin.fileno()),
            "file": lambda: self._file_source(parts, columns, period),
        }
        source: Source | None = self._open("source", address, openers)
        if source is not None:
            return source
        return Inbox(self._own_messages(address, OWN.find(address, "source", self._where)), period)

    def sink(self, address: str) -> Sink:
        """Opens a sink of results.

        Raises:
            InputError: if it cannot be opened.
        """
        parts = urlsplit(address)
        openers: dict[str, Callable[[], Sink]] = {
            "udp": lambda: self._udp_sink(parts),
            "serial": lambda: self.queued_sink(writer(self._serial(parts).fileno()), room=1),
            "stdio": lambda: self.queued_sink(print_out),
            "file": lambda: self.queued_sink(self._file_writer(file_path(parts))),
        }
        sink: Sink | None = self._open("sink", address, openers)
        return sink or self.queued_sink(self._own_sink(address), room=1)

    def queued_sink(self, take: Sink, room: int = ROOM) -> Sink:
        """Non-blocking wrapper of a sink; one that commands a device has room for the newest result alone."""
        outbox = Outbox[tuple[bytes, dict[str, Any]]](lambda sent: take(*sent), self._until, room)
        self._outboxes.append(outbox)
        self._stack.callback(outbox.close)
        return lambda message, results: outbox.put((message, results))

    def _own_messages(self, address: str, messages: Callable[[], Iterable[Message]]) -> Iterator[Message]:
        """Yields the messages of a user's generator; errors name it."""
        with blamed_on("source", address, self._where):
            yield from messages()

    def _own_sink(self, address: str) -> Sink:
        function = OWN.find(address, "sink", self._where)

        def take(_: bytes, results: dict[str, Any]) -> None:
            with blamed_on("sink", address, self._where):
                function(results)

        return take

    def _open(self, field: str, address: str, openers: Mapping[str, Callable[[], Any]]) -> Any:
        """Opens the source or sink of an address; None if it is a user's function."""
        scheme, colon, target = address.partition(":")
        if not colon or (scheme not in openers and target.startswith("/")):
            expected = (
                f"give an address that begins with {', '.join(f'{name}:' for name in openers)}, or module:function"
            )
            raise InputError(self._where, field, address, expected)
        try:
            return openers[scheme]() if scheme in openers else None
        except InputError:
            raise
        except (OSError, ValueError, RuntimeError, OverflowError) as error:  # the last of a baud rate
            reason = getattr(error, "strerror", None) or error
            raise InputError(self._where, field, address, f"cannot be opened: {reason}") from error

    def _bind(self, parts: SplitResult) -> socket.socket:
        udp_socket = self._stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        udp_socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        udp_socket.bind(_host_and_port(parts))
        udp_socket.setblocking(False)
        return udp_socket

    def _udp_sink(self, parts: SplitResult) -> Sink:
        sender = self._stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        sender.setblocking(False)
        destination = _host_and_port(parts)

        def send(message: bytes, _: dict[str, Any]) -> None:
            with suppress(OSError):  # nobody listens, or the network is busy: datagrams may be lost
                sender.sendto(message, destination)

        return send

    def _serial(self, parts: SplitResult) -> Any:
        try:
            from serial import Serial
        except ImportError:
            expected = "requires pyserial: pip install 'soft-gripper[live]'"
            raise InputError(self._where, "source", parts.geturl(), expected) from None
        name = unquote(parts.path)
        baud = int(parse_qs(parts.query).get("baud", [str(_BAUD_RATE)])[0])
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
        """A writer of a file; opens a pipe at the first result, because that waits for a reader."""
        if path.is_fifo():
            descriptors: list[int] = []

            def write(message: bytes, _: dict[str, Any]) -> None:
                if not descriptors:
                    descriptors.append(os.open(path, os.O_WRONLY))
                write_all(descriptors[0], message)

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
        return (line for line_number, line in lines if line_number or line.lstrip()[:1] in b"{+-.0123456789")


def _lines(path: Path, file: IO[bytes]) -> Iterator[bytes]:
    for number, line in enumerate(iter(lambda: file.readline(MAX_MESSAGE_BYTES + 1), b""), 1):
        if len(line) > MAX_MESSAGE_BYTES:
            raise InputError(path, "line", number, f"has more than {MAX_MESSAGE_BYTES} bytes; give a reading a line")
        yield line


_Selector = getattr(selectors, "PollSelector", selectors.SelectSelector)  # epoll refuses files on a disk


def _is_readable(file: socket.socket | int, timeout: float) -> bool:
    """Whether a socket or descriptor, of any number, becomes readable within a timeout, s."""
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
        if not _is_readable(self._socket, timeout):
            return []
        messages: list[Message] = []
        while len(messages) < MAX_WAITING:
            try:
                messages.append(self._socket.recv(MAX_MESSAGE_BYTES + 1))
            except BlockingIOError:
                break
        return messages


class LineSource:
    """The lines that can be read from a file descriptor, such as a serial port."""

    def __init__(self, descriptor: int):
        self._descriptor = descriptor
        self._partial_line = b""
        self.is_over = False
        self._is_cut = False  # whether the partial line is the rest of one that was too long

    def receive(self, timeout: float) -> list[Message]:
        if self.is_over or not _is_readable(self._descriptor, timeout):
            return []
        try:
            data = os.read(self._descriptor, MAX_MESSAGE_BYTES)
        except BlockingIOError:
            return []
        except OSError:  # unplugged
            data = b""
        self.is_over = not data
        *lines, self._partial_line = (self._partial_line + data).split(b"\n")
        if self._is_cut:
            self._partial_line, self._is_cut = self._partial_line if lines else b"", not lines
            lines = lines[1:]
        if len(self._partial_line) > MAX_MESSAGE_BYTES:  # malformed: it is passed on, and counted
            lines, self._partial_line, self._is_cut = [*lines, self._partial_line], b"", True
        return [line for line in lines if line.strip()]


class PacedSource:
    """Messages of a file or of a generator, one every period, or one per call with period 0."""

    def __init__(self, messages: Iterable[Message], period: float):
        self._messages = iter(messages)
        self._period = period
        self.is_over = False
        self._due = time.monotonic()

    def receive(self, timeout: float) -> list[Message]:
        wait_time = self._due - time.monotonic()
        if self._period and wait_time > 0:
            time.sleep(min(wait_time, timeout))
            if wait_time > timeout:
                return []
        self._due += self._period
        for message in self._messages:
            return [message]
        self.is_over = True
        return []


def _host_and_port(parts: SplitResult) -> tuple[str, int]:
    if parts.port is None:
        raise ValueError("give a port, as in udp://127.0.0.1:5005")
    return parts.hostname or LOOPBACK, parts.port


def file_path(parts: SplitResult) -> Path:
    """Path of the file at an address."""
    return Path(unquote(f"{parts.netloc}{parts.path}"))


def writer(descriptor: int) -> Sink:
    """Writes messages to a file descriptor; waits for room."""
    return lambda message, _: write_all(descriptor, message)


def print_out(message: bytes, _: dict[str, Any]) -> None:
    """Writes a message to standard output; waits for room."""
    try:
        descriptor = sys.stdout.fileno()
    except (AttributeError, OSError):  # not a file, but a substitute
        sys.stdout.write(message.decode())
    else:  # bypasses Python's buffer, whose lock would block while nobody reads
        write_all(descriptor, message)
