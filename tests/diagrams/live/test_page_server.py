import json
import re
import threading
import time
from collections.abc import Iterator
from http.client import HTTPConnection

import pytest
from pydrake.geometry import Meshcat

from soft_gripper.diagrams.live import page_server as module
from soft_gripper.diagrams.live.page_server import page_server
from soft_gripper.diagrams.live.signal_feed import SignalFeed
from soft_gripper.errors import InputError

HOST = "127.0.0.1"


@pytest.fixture(scope="module")
def meshcat() -> Meshcat:
    return Meshcat()


@pytest.fixture
def feed() -> SignalFeed:
    return SignalFeed(("a", "b", "c"))


@pytest.fixture
def port(meshcat: Meshcat, feed: SignalFeed) -> Iterator[int]:
    with page_server({"name": "a"}, meshcat, feed, HOST) as port:
        yield port


def get(port: int, path: str):
    connection = HTTPConnection(HOST, port, timeout=5)
    connection.request("GET", path)
    return connection.getresponse()


def test_the_page_is_whole(port: int) -> None:
    page = get(port, "/").read().decode()
    for name in re.findall(r'(?:src|href)="([^":]+)"', page):
        assert get(port, f"/{name}").status == 200, name
    assert "http://" not in page
    assert "https://" not in page
    assert json.loads(get(port, "/about.json").read()) == {"name": "a"}


def test_the_scene_is_meshcats_page_with_its_own_socket_and_scripts(port: int, meshcat: Meshcat) -> None:
    page = get(port, "/scene").read().decode()
    assert page.index(f":{meshcat.port()}/") < page.index("new WebSocket(url)")
    (script,) = re.findall(r'<script[^>]* src="([^"]+)"', page)
    answer = get(port, f"/{script}")
    assert answer.status == 302
    assert answer.getheader("Location") == f"http://{HOST}:{meshcat.port()}/{script}"
    assert get(meshcat.port(), f"/{script}").status == 200


def test_signals_come_as_they_are_sent(port: int, feed: SignalFeed) -> None:
    stream = get(port, "/live?signal=a&signal=b")
    while feed.wanted != {"a", "b"}:
        pass
    feed.send({"time": 1.0}, {"a": [2.0], "b": [3.0], "c": [4.0]})
    line = stream.readline().decode()
    assert json.loads(line.removeprefix("data: ")) == {"status": {"time": 1.0}, "values": {"a": [2.0], "b": [3.0]}}
    feed.close()
    assert b"event: end" in stream.read()


def test_a_page_of_something_else_gets_no_signals(port: int, feed: SignalFeed) -> None:
    assert get(port, "/live?signal=a&signal=d").status == 404
    assert feed.wanted == set()


def test_a_browser_that_is_gone_is_no_complaint(port: int, feed: SignalFeed, capfd) -> None:
    get(port, "/live?signal=a").close()
    deadline = time.monotonic() + 5
    while feed.wanted and time.monotonic() < deadline:
        feed.send({}, {"a": [0.0]})
        time.sleep(0.01)
    assert feed.wanted == set()
    assert capfd.readouterr().err == ""


def test_no_thread_and_no_port_is_left(meshcat: Meshcat, feed: SignalFeed) -> None:
    before = set(threading.enumerate())
    with page_server({}, meshcat, feed, HOST) as port:
        stream, idle = get(port, "/live?signal=a"), HTTPConnection(HOST, port)
        idle.connect()
    assert set(threading.enumerate()) == before
    assert b"event: end" in stream.read()
    with pytest.raises(ConnectionRefusedError):
        get(port, "/")


def test_a_port_that_is_taken_is_passed_over(meshcat: Meshcat, port: int) -> None:
    with page_server({}, meshcat, SignalFeed(("a", "b", "c")), HOST) as other:
        assert other in module.PORTS
        assert other != port


def test_an_address_of_another_machine_is_refused(meshcat: Meshcat, feed: SignalFeed, monkeypatch) -> None:
    monkeypatch.setattr(module, "PORTS", range(7100, 7102))
    with pytest.raises(InputError, match=r"host = '192\.0\.2\.1'"):
        page_server({}, meshcat, feed, "192.0.2.1").__enter__()
