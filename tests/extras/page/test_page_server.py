"""The server of the live page, as a browser and as an attacker find it."""

import json
import re
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from http.client import HTTPConnection, HTTPResponse
from urllib.parse import urlsplit

import pytest
from pydrake.geometry import Box, Meshcat, Rgba
from waiting import wait_until
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect

from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat
from soft_gripper.errors import InputError
from soft_gripper.extras.page import page_server as module
from soft_gripper.extras.page.live_page import SessionPage
from soft_gripper.extras.page.page_server import page_server
from soft_gripper.extras.page.signal_feed import MAX_UNSEEN, SignalFeed
from soft_gripper.extras.page.viewing import has_failed

HOST = "127.0.0.1"
STOP = {"button": "stop"}
SECOND = 20.0  # s of this machine, however busy, for what takes a moment


class Taken:
    """A panel that takes `STOP` alone, and remembers what it was given."""

    def __init__(self) -> None:
        self.messages: list[object] = []

    def take(self, message: object) -> bool:
        self.messages.append(message)
        return message == STOP


@dataclass
class Served:
    """A page that is served."""

    address: str
    live: SessionPage
    panel: Taken
    feed: SignalFeed

    @property
    def port(self) -> int:
        return urlsplit(self.address).port or 0

    @property
    def token(self) -> str:
        return urlsplit(self.address).path.strip("/")

    def get(self, path: str = "", **headers: str) -> HTTPResponse:
        return get(self.port, f"/{self.token}/{path}", **headers)

    def open(self, path: str = "live", host: str = "localhost", origin: str | None = None) -> ClientConnection:
        """A WebSocket, as the page opens it."""
        authority = f"{host}:{self.port}"
        return connect(
            f"ws://{authority}/{self.token}/{path}",
            sock=socket.create_connection((HOST, self.port), timeout=SECOND),
            origin=f"http://{authority}" if origin is None else origin,
            compression=None,
            proxy=None,
        )


def get(port: int, path: str, **headers: str) -> HTTPResponse:
    connection = HTTPConnection(HOST, port, timeout=SECOND)
    connection.request("GET", path, headers=headers)
    return connection.getresponse()


@pytest.fixture(scope="module")
def meshcat() -> Meshcat:
    return hidden_meshcat()


@pytest.fixture
def served(meshcat: Meshcat) -> Iterator[Served]:
    panel, feed, scene = Taken(), SignalFeed(("a", "b", "c")), meshcat.web_url()
    live = SessionPage({"name": "a"}, panel, feed)  # type: ignore[arg-type]
    with page_server(HOST, lambda: scene, live) as address:
        yield Served(address, live, panel, feed)
    assert not has_failed(meshcat)


def test_the_page_is_whole(served: Served) -> None:
    page = served.get().read().decode()
    names = re.findall(r'(?:src|href)="([^":]+)"', page)
    assert "page.js" in names
    scripts = [served.get(name).read().decode() for name in names if name.endswith(".js")]
    names += re.findall(r'from "\./([^"]+)"', "".join(scripts))
    assert "plot.js" in names
    for name in names:
        assert served.get(name).status == 200, name
    assert not re.search("https?://", page)
    assert json.loads(served.get("about.json").read()) == {"name": "a"}


def test_the_scene_is_meshcats_with_what_belongs_to_it(served: Served, meshcat: Meshcat) -> None:
    page = served.get("scene/").read().decode()
    (script,) = re.findall(r'<script[^>]* src="([^"]+)"', page)
    answer = served.get(f"scene/{script}")
    assert answer.status == 200
    assert len(answer.read()) > 1e5
    assert answer.headers["Content-Type"].startswith("text/javascript"), "browsers run nothing else"
    meshcat.SetObject("box", Box(1, 1, 1), Rgba(1, 0, 0))
    with served.open("scene/") as socket:
        messages = iter(lambda: socket.recv(timeout=SECOND), None)
        assert any(b"box" in message for message in messages if isinstance(message, bytes))


@pytest.mark.parametrize(
    "path", ["scene/download", "scene/../", "scene/cas-v1/..", "scene/cas-v1/a/../..", "x", "live"]
)
def test_there_is_nothing_else(served: Served, path: str) -> None:
    assert served.get(path).status == 404


def test_no_token_leaves_in_a_referer_and_no_page_frames_this_one(served: Served) -> None:
    for path in ("", "page.js", "scene/"):
        answer = served.get(path)
        assert answer.getheader("Referrer-Policy") == "no-referrer"
        assert "frame-ancestors 'self'" in answer.getheader("Content-Security-Policy")
        assert answer.getheader("X-Content-Type-Options") == "nosniff"


def test_signals_come_as_they_are_asked_for(served: Served) -> None:
    with served.open() as socket:
        socket.send(json.dumps({"signals": ["a", "b"]}))
        wait_until(lambda: served.feed.wanted_signals == {"a", "b"})
        served.feed.send({"time": 1.0}, {"a": [2.0], "b": [3.0], "c": [4.0]})
        expected = {"number": 1, "status": {"time": 1.0, "late": 0.0}, "values": {"a": [2.0], "b": [3.0]}}
        assert json.loads(socket.recv(timeout=SECOND)) == expected
    wait_until(lambda: not served.feed.wanted_signals)


@pytest.mark.parametrize("token", ["", "x", "a" * 22, "a" * 5000, "%00", "\x80", "..", "live"])
@pytest.mark.parametrize("path", ["", "about.json", "scene/", "live"])
def test_who_does_not_know_the_token_gets_nothing(served: Served, token: str, path: str) -> None:
    request = f"GET /{token}/{path} HTTP/1.1\r\nHost: localhost\r\n\r\n".encode("latin-1")
    assert raw(served, request)[:12] in (b"HTTP/1.1 404", b"HTTP/1.1 400", b"")
    assert served.token.encode() not in raw(served, request)


def test_a_socket_needs_the_token(served: Served) -> None:
    stranger = Served(served.address.replace(served.token, "a" * 22), served.live, served.panel, served.feed)
    for path in ("live", "scene/"):
        with pytest.raises(InvalidStatus, match="404"):
            stranger.open(path)


@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://localhost", "http://localhost:1", "file://", ""]
)
@pytest.mark.parametrize("path", ["live", "scene/"])
def test_a_page_from_elsewhere_opens_no_socket_even_with_the_token(served: Served, origin: str, path: str) -> None:
    with pytest.raises(InvalidStatus, match="403"):
        served.open(path, origin=origin)
    assert served.panel.messages == []


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:7100", "localhost.evil.example", "[", "[]", "[::1", "", "a b", "@localhost",
             "localhost@evil.example", "localhost:x", "127.0.0.1.evil.example", "2130706433.example"]
)  # fmt: skip
def test_a_foreign_name_for_this_machine_is_refused(served: Served, host: str, capfd) -> None:
    assert served.get(Host=host).status == 403
    assert capfd.readouterr().err == ""


def test_two_hosts_are_none(served: Served) -> None:
    request = f"GET /{served.token}/ HTTP/1.1\r\nHost: localhost\r\nHost: localhost\r\n\r\n".encode()
    assert raw(served, request).startswith(b"HTTP/1.1 403")


def raw(served: Served, request: bytes) -> bytes:
    """What is answered to bytes, until the connection ends."""
    with socket.create_connection((HOST, served.port), timeout=SECOND) as client:
        client.sendall(request)
        return b"".join(iter(lambda: client.recv(65536), b""))


@pytest.mark.parametrize(
    "message", [b"\xc1", b"", "", "{", "null", "NaN", '{"signals": ["d"]}', '{"signals": [1]}', '{"signals": "a"}',
                '{"signals": null}', "[" * 4000, '{"slider": "a", "value": NaN}', b"\xff\xfe", "1" * 4000]
)  # fmt: skip
def test_a_message_that_is_no_command_is_counted(served: Served, message: str | bytes, capfd) -> None:
    with served.open() as socket:
        socket.send(message)
        wait_until(lambda: served.live.refused == 1)
        socket.send(json.dumps(STOP))
        wait_until(lambda: served.panel.messages[-1:] == [STOP])
    assert served.feed.wanted_signals == set()
    assert capfd.readouterr().err == ""


def test_a_flood_ends_its_connection_while_the_scene_moves(served: Served, meshcat: Meshcat) -> None:
    def flood() -> None:
        for _ in range(10):
            with served.open("scene/") as socket, suppress(ConnectionClosed):
                while True:
                    socket.send("{}")

    flooding = threading.Thread(target=flood, daemon=True)
    flooding.start()
    deadline = time.monotonic() + SECOND
    while flooding.is_alive():
        assert time.monotonic() < deadline, "it goes on"
        for i in range(50):  # in this thread, since Drake accepts no other
            meshcat.SetProperty(f"moving{i}", "visible", True)
        time.sleep(0.02)


def end(socket: ClientConnection) -> None:
    """Waits until the connection has ended."""
    with pytest.raises(ConnectionClosed):  # noqa: PT012
        while True:
            socket.recv(timeout=SECOND)


def test_a_request_that_comes_slowly_is_cut_off(served: Served, monkeypatch) -> None:
    monkeypatch.setattr(module, "REQUEST_TIME", 0.3)
    with socket.create_connection((HOST, served.port), timeout=SECOND) as client:
        began = time.monotonic()
        with pytest.raises(OSError):  # noqa: PT011, PT012
            while time.monotonic() - began < SECOND:
                client.sendall(b"G")
                time.sleep(0.05)
    assert time.monotonic() - began < SECOND


def test_a_browser_that_does_not_read_holds_nothing_up(served: Served) -> None:
    with served.open() as stuck, served.open() as reading:
        stuck.recv_bufsize = 0
        for client in (stuck, reading):
            client.send(json.dumps({"signals": ["a"]}))
        wait_until(lambda: len(served.feed._readers) == 2)
        wait_until(lambda: all(reader.signals for reader in served.feed._readers.values()))
        _, listener = served.feed._readers
        for i in range(200):
            served.feed.send({"time": i, "note": "x" * 20_000}, {"a": [1.0]})
            message = json.loads(reading.recv(timeout=SECOND))
            assert message["status"]["time"] == i
            reading.send(json.dumps({"seen": message["number"]}))
            wait_until(lambda: not served.feed._readers[listener].unseen)


def test_a_slow_browser_is_shown_what_is_new_and_told_that_it_is_late(served: Served, monkeypatch) -> None:
    """Frames come 200 times a second, and it takes a tenth of a second for each."""
    frame, now = 0.005, 0.0  # s
    monkeypatch.setattr(served.feed, "_clock", lambda: now)
    delays, lates = list[float](), list[float]()
    with served.open() as slow:
        wait_until(lambda: served.feed._readers)
        (reader,) = served.feed._readers.values()
        for _ in range(25):
            for _ in range(20):
                now += frame
                served.feed.send({"time": now}, {})
            message = json.loads(slow.recv(timeout=SECOND))
            delays.append(now - message["status"]["time"])
            lates.append(message["status"]["late"])
            slow.send(json.dumps({"seen": message["number"]}))
            wait_until(lambda number=message["number"]: all(unseen > number for unseen, _ in reader.unseen))
    assert max(delays) < (MAX_UNSEEN + 1) * 20 * frame, "half of what was sent waits"
    assert 0.2 < lates[-1] < 0.5
    assert served.live.refused == 0


@pytest.mark.slow
def test_no_thread_and_no_port_is_left_whatever_clients_do(meshcat: Meshcat, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PORTS", range(7410, 7430))  # which no other test takes meanwhile
    before, scene, feed = set(threading.enumerate()), meshcat.web_url(), SignalFeed(("a",))
    live = SessionPage({}, Taken(), feed)  # type: ignore[arg-type]
    with ExitStack() as clients:
        with page_server(HOST, lambda: scene, live) as address:
            served = Served(address, live, Taken(), feed)
            sockets = [clients.enter_context(served.open(path)) for path in ("live", "scene/")]
            for sent in (b"", b"G", f"GET /{served.token}/scene/ HTTP/1.1\r\nHost: localhost".encode()):
                client = clients.enter_context(socket.create_connection((HOST, served.port), timeout=SECOND))
                client.sendall(sent)
            wait_until(lambda: feed._readers)
            began = time.monotonic()
        assert time.monotonic() - began < 2.0, "no client is waited for"
        assert json.loads(sockets[0].recv(timeout=SECOND)) == {"end": True}
    wait_until(lambda: set(threading.enumerate()) <= before)
    with pytest.raises(ConnectionRefusedError):
        served.get()


def test_an_address_of_another_machine_is_refused(monkeypatch) -> None:
    monkeypatch.setattr(module, "PORTS", range(7100, 7102))
    with pytest.raises(InputError) as error:
        page_server("192.0.2.1", lambda: "").__enter__()
    assert (error.value.field, error.value.value) == ("host", "192.0.2.1")


@pytest.mark.parametrize(("host", "shown"), [("0.0.0.0", socket.gethostname()), ("::1", "[::1]"), (HOST, "localhost")])
def test_the_address_can_be_opened_from_where_it_is_meant_for(meshcat: Meshcat, host: str, shown: str) -> None:
    scene = meshcat.web_url()
    try:
        with page_server(host, lambda: scene) as address:
            assert address.startswith(f"http://{shown}:")
    except InputError:
        pytest.skip(f"there is no {host} here")
