"""One server for all browser content: a page, the WebSocket of its plots and commands, the scene of a Meshcat.

Opening a page requires the token in its address, which is printed for the user only. A page from elsewhere can
connect to any port of this machine, but does not know the token; it is also refused by its Origin, and by the Host
name that it has made this machine answer to (DNS rebinding).

The scene is Meshcat's own page, and what Meshcat sends to it. Meshcat itself is hidden (`hidden_meshcat`), has no
sliders and no buttons, and receives nothing that a browser sends: so a client of the scene cannot command anything.

All of it runs in one asyncio thread, which waits for no client. A client whose request is not complete in
time, or that does not answer pings, is disconnected; messages that a browser is too slow to receive are dropped.
"""

import asyncio
import hmac
import ipaddress
import json
import logging
import re
import secrets
import socket
import time
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from http import HTTPStatus
from http.client import HTTPConnection, HTTPException
from threading import Thread
from typing import Any, Protocol
from urllib.parse import urlsplit

from websockets.asyncio.server import ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from soft_gripper.diagrams.view.meshcat_view import LOOPBACK
from soft_gripper.errors import InputError

PORTS = range(7100, 7200)  # after those of Meshcat
MOST_CONNECTIONS = 150
MOST_MESSAGES = 300  # per connection and second
REQUEST_TIME = 3.0  # s until a whole request must have arrived
_ANSWER_TIME = 60.0  # s until it must have been answered, and read
_PING_TIME = 10.0  # s between pings, each of which must be answered within 20 s
_STALLED_TIME = 60.0  # s for which a browser may accept no data of a scene
_END_TIME = 0.3  # s that connections have to close at the end
_MAX_MESSAGE_BYTES = 4096  # of an incoming message
_MAX_BACKLOG = 2**20  # maximum backlog of a browser, bytes
_HTML_TYPE = "text/html; charset=utf-8"
_LIVE_PATH = "live"
_SCENE_PATH = "scene/"
_AUTHORITY_PATTERN = re.compile(r"(?:\[([\da-f:.]+)\]|([\w.-]+))(?::\d{1,5})?", re.ASCII | re.IGNORECASE)
_MESHCAT_PATHS = re.compile(r"(cas-v1/[0-9a-f]{1,128}|[\w-]+\.js)?")  # its page, and the files that belong to it
# What opens a WebSocket of Meshcat, and what keeps it open: uWebSockets closes one that is silent for two minutes.
_SOCKET_REQUEST = (
    b"GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
)
_PONG_FRAME = b"\x8a\x80\0\0\0\0"
_COMMON_HEADERS = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "X-Content-Type-Options": "nosniff"}
_POLICY = "connect-src 'self' ws: wss:; base-uri 'none'; form-action 'none'; object-src 'none'; frame-ancestors 'self'"
_OWN_POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; img-src data:; frame-src 'self'; " + _POLICY
# Meshcat's page has its scripts and styles inside, makes others from text, and loads textures from data.
_SCENE_POLICY = "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; " + _POLICY.replace(
    "wss:", "wss: data: blob:"
)
_REFUSAL_TEXT = "This address is not, or no longer, in use: open the one that soft-gripper has printed.\n"
_QUIET_LOGGER = logging.Logger("page")  # the terminal is the user's
_QUIET_LOGGER.addHandler(logging.NullHandler())
Answer = tuple[HTTPStatus, str, bytes]  # and the type of its body, and the body


class LivePage(Protocol):
    """The surroundings of a scene: files, and the messages that a page is sent and sends."""

    def file(self, path: str) -> tuple[str, bytes] | None:
        """Type and content of a file; None if there is no such file."""

    def listen(self, listener: Callable[[str], None]) -> None:
        """Adds a `listener`, which does not wait, for messages to the page."""

    def take(self, message: str | bytes, listener: Callable[[str], None]) -> None:
        """Takes a message from the page of a listener."""

    def leave(self, listener: Callable[[str], None]) -> None:
        """Removes a `listener`."""


@contextmanager
def page_server(host: str, scene: Callable[[], str], live: LivePage | None = None) -> Iterator[str]:
    """Serves at the first port that is free until the block ends; then no thread and no connection is left.

    Args:
        host: address to listen at; "" means all addresses of this machine.
        scene: returns the address of the Meshcat that is shown; a browser that has lost it asks again. (Drake ends the
            process if a thread other than the first asks a Meshcat for it.)
        live: what surrounds the scene; None: the page is the scene alone.

    Yields:
        The address to open.

    Raises:
        InputError: if no port is free, or the address is not one of this machine.
    """
    listening = _listen(host)
    server = _PageServer(_names(host), scene, live)
    thread = Thread(target=server.run, args=(listening,))
    thread.start()
    path = _SCENE_PATH if live is None else ""
    try:
        yield f"http://{_public_host(host)}:{listening.getsockname()[1]}/{server.token}/{path}"
    finally:
        server.end()
        thread.join()


def _listen(host: str) -> socket.socket:
    reason = ""
    for port in PORTS:
        try:
            addresses = socket.getaddrinfo(host or None, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
            family, *_, address = addresses[0]
            return socket.create_server(address, family=family, backlog=MOST_CONNECTIONS)
        except (OSError, UnicodeError) as error:
            reason = getattr(error, "strerror", None) or str(error)
    expected = f"none of the ports {PORTS[0]} to {PORTS[-1]} is available there ({reason})"
    raise InputError("page", "host", host, expected)


def _public_host(host: str) -> str:
    """The host in the address of the page: a name that works wherever the page can be opened."""
    if host == LOOPBACK:
        return "localhost"
    if host in ("", "0.0.0.0", "::"):
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host


def _names(host: str) -> frozenset[str]:
    """The names of this machine; a foreign name may resolve to it too, but is not among these."""
    full_name = socket.gethostname().lower()
    name = full_name.split(".")[0]
    return frozenset({"localhost", full_name, name, f"{name}.local", host.lower()})


class _PageServer:
    """Answers requests, in the thread that calls `run`."""

    def __init__(self, names: frozenset[str], scene: Callable[[], str], live: LivePage | None):
        self.token = secrets.token_urlsafe(16)
        self._names, self._scene, self._live = names, scene, live
        self._open: set[_Connection] = set()
        self._loop, self._over = asyncio.new_event_loop(), asyncio.Event()
        self._loop.set_exception_handler(lambda *_: None)

    def run(self, listening: socket.socket) -> None:
        """Serves until `end`."""
        with asyncio.Runner(loop_factory=lambda: self._loop) as runner:
            runner.run(self._serve(listening))

    def end(self) -> None:
        """Ends `run`, from another thread."""
        with suppress(RuntimeError):  # it has already ended
            self._loop.call_soon_threadsafe(self._over.set)

    async def _serve(self, listening: socket.socket) -> None:
        server = await serve(
            self._handle,
            sock=listening,
            process_request=self._respond,
            create_connection=partial(_Connection, self._open),  # type: ignore[arg-type]
            compression=None,
            server_header=None,
            open_timeout=_ANSWER_TIME,
            ping_interval=_PING_TIME,
            close_timeout=1.0,
            max_size=_MAX_MESSAGE_BYTES,
            logger=_QUIET_LOGGER,
        )
        await self._over.wait()
        for connection in self._open:
            if connection.request is not None and connection.request.path.endswith(_LIVE_PATH):
                self._say(connection, json.dumps({"end": True}))
        server.close()
        await asyncio.wait([asyncio.create_task(server.wait_closed())], timeout=_END_TIME)
        for connection in self._open:
            connection.transport.abort()

    async def _respond(self, _: ServerConnection, request: Request) -> Response | None:
        """The answer to a request; None for a WebSocket request, which is then opened."""
        answer = await self._answer(request)
        if answer is None:
            return None
        status, kind, body = answer
        is_scene = request.path.partition("/")[2].partition("/")[2].startswith(_SCENE_PATH)
        headers = {**_COMMON_HEADERS, "Connection": "close", "Content-Length": str(len(body)), "Content-Type": kind}
        headers["Content-Security-Policy"] = _SCENE_POLICY if is_scene else _OWN_POLICY
        return Response(status.value, status.phrase, Headers(headers), body)

    async def _answer(self, request: Request) -> Answer | None:
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        token, _, path = request.path.partition("?")[0].removeprefix("/").partition("/")
        if len(hosts) != 1 or not self._is_ours(hosts[0]):
            return _refusal(HTTPStatus.FORBIDDEN)
        if not hmac.compare_digest(token.encode(errors="replace"), self.token.encode()):
            return _refusal(HTTPStatus.NOT_FOUND)
        if "Upgrade" in request.headers:
            if origins not in ([f"http://{hosts[0]}"], [f"https://{hosts[0]}"]):
                return _refusal(HTTPStatus.FORBIDDEN)
            return None if path in self._sockets else _refusal(HTTPStatus.NOT_FOUND)
        return await self._file(path)

    def _is_ours(self, authority: str) -> bool:
        """Whether a Host is an IP address, which nobody can redirect, or a name of this machine."""
        match = _AUTHORITY_PATTERN.fullmatch(authority)
        if match is None:
            return False
        address, name = match.groups()
        with suppress(ValueError):
            return bool(ipaddress.ip_address(address or name))
        return name is not None and name.lower() in self._names

    @property
    def _sockets(self) -> tuple[str, ...]:
        return (_SCENE_PATH,) if self._live is None else (_SCENE_PATH, _LIVE_PATH)

    async def _file(self, path: str) -> Answer:
        if path.startswith(_SCENE_PATH):
            return await self._meshcat_file(path.removeprefix(_SCENE_PATH))
        content = None if self._live is None else self._live.file(path)
        return _refusal(HTTPStatus.NOT_FOUND) if content is None else (HTTPStatus.OK, *content)

    async def _meshcat_file(self, path: str) -> Answer:
        if not _MESHCAT_PATHS.fullmatch(path):
            return _refusal(HTTPStatus.NOT_FOUND)
        try:
            return await asyncio.to_thread(_fetch, self._scene(), path)
        except (OSError, HTTPException):
            return _refusal(HTTPStatus.SERVICE_UNAVAILABLE)

    async def _handle(self, connection: ServerConnection) -> None:
        assert connection.request is not None
        if connection.request.path.endswith(_LIVE_PATH):
            await self._talk(connection)
        else:
            await self._show(connection)

    async def _talk(self, connection: ServerConnection) -> None:
        """Sends updates, and receives commands."""
        assert self._live is not None

        def listener(message: str) -> None:
            self._loop.call_soon_threadsafe(self._say, connection, message)

        self._live.listen(listener)
        try:
            async for message in _limit_rate(connection):
                self._live.take(message, listener)
        finally:
            self._live.leave(listener)

    def _say(self, connection: ServerConnection, message: str) -> None:
        """Sends a message, or drops it if the browser is far behind."""
        if connection.transport.get_write_buffer_size() < _MAX_BACKLOG:
            broadcast([connection], message)

    async def _show(self, connection: ServerConnection) -> None:
        """Passes on messages of Meshcat, and sends none to it, until either side has gone."""
        address = urlsplit(self._scene())
        reader, writer = await asyncio.open_connection(address.hostname, address.port)
        try:
            writer.write(_SOCKET_REQUEST)
            await reader.readuntil(b"\r\n\r\n")
            ends = [asyncio.create_task(end) for end in (_hand_on(reader, writer, connection), _ignore(connection))]
            await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        finally:
            writer.close()
            connection.transport.abort()  # a closing frame might fall into one of Meshcat's
        # The other one ends now. It is not cancelled, since `wait_for` can lose that in Python 3.11.
        await asyncio.gather(*ends, return_exceptions=True)


class _Connection(ServerConnection):
    """A connection that is closed if there are too many, or if its request does not arrive in time."""

    def __init__(self, others: "set[_Connection]", *arguments: Any, **options: Any):
        super().__init__(*arguments, **options)
        self._others = others

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        self._others.add(self)
        if len(self._others) > MOST_CONNECTIONS:
            self.transport.abort()
        self.loop.call_later(REQUEST_TIME, self._require_request)

    def start_keepalive(self) -> None:
        """Sends pings, but not between the frames of a scene."""
        if self.request is not None and self.request.path.endswith(_LIVE_PATH):
            super().start_keepalive()

    def connection_lost(self, exc: Exception | None) -> None:
        self._others.discard(self)
        super().connection_lost(exc)

    def _require_request(self) -> None:
        if self.request is None:
            self.transport.abort()


def _refusal(status: HTTPStatus) -> Answer:
    return status, "text/plain; charset=utf-8", _REFUSAL_TEXT.encode()


def _kind(name: str) -> str:
    """The type of a file of Meshcat, which it does not always state; browsers run nothing else as a script."""
    if name.endswith(".js"):
        return "text/javascript; charset=utf-8"
    return "application/octet-stream" if name else _HTML_TYPE


def _fetch(url: str, path: str) -> Answer:
    """Fetches a file of Meshcat."""
    address = urlsplit(url)
    assert address.hostname is not None
    connection = HTTPConnection(address.hostname, address.port, timeout=1.0)
    try:
        connection.request("GET", f"/{path}")
        answer = connection.getresponse()
        # Newer Drakes address files by their hash and state their names beside.
        kind = answer.getheader("Content-Type") or _kind(answer.getheader("Meshcat-Cas-Filename", path))
        return HTTPStatus(answer.status), kind, answer.read()
    finally:
        connection.close()


async def _limit_rate(connection: ServerConnection) -> AsyncIterator[str | bytes]:
    """Messages of a connection, which ends if they arrive too fast."""
    start, number = time.monotonic(), 0
    async for message in connection:
        if time.monotonic() - start > 1.0:
            start, number = time.monotonic(), 0
        number += 1
        if number > MOST_MESSAGES:
            return
        yield message


async def _hand_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter, connection: ServerConnection) -> None:
    """Hands on frames as they are: some hundred come every 50 ms, and to read each would take half of that time."""
    pong_time = time.monotonic()
    while data := await reader.read(2**16):
        connection.transport.write(data)
        await asyncio.wait_for(connection.drain(), _STALLED_TIME)
        if time.monotonic() - pong_time > _PING_TIME:
            pong_time = time.monotonic()
            writer.write(_PONG_FRAME)


async def _ignore(connection: ServerConnection) -> None:
    async for _ in _limit_rate(connection):
        pass
