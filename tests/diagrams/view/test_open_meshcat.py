import os
import socket
from urllib.parse import urlsplit

import pytest

from soft_gripper.diagrams.view.meshcat_view import LOOPBACK, cut_off, has_failed, hidden_meshcat, open_meshcat


def test_a_hidden_meshcat_is_elsewhere_each_time() -> None:
    first, second = hidden_meshcat(), hidden_meshcat()
    hosts = [urlsplit(meshcat.web_url()).hostname or "" for meshcat in (first, second)]
    assert all(host.startswith("127.") for host in hosts)
    assert len({LOOPBACK, *hosts}) == 3 or set(hosts) == {LOOPBACK}, "the loopback of macOS has one address"
    assert not {first.port(), second.port()} & set(range(7000, 7100))
    assert not has_failed(first)


def test_an_open_meshcat_is_of_this_machine_alone() -> None:
    assert urlsplit(open_meshcat().web_url()).hostname in (LOOPBACK, "localhost")


def test_connections_at_one_port_are_cut_off_and_no_file_stays_open() -> None:
    with socket.create_server((LOOPBACK, 0)) as one, socket.create_server((LOOPBACK, 0)) as other:
        clients = [socket.create_connection(server.getsockname()) for server in (one, other)]
        served = [server.accept()[0] for server in (one, other)]
        before = next_descriptor()
        cut_off(f"http://{LOOPBACK}:{one.getsockname()[1]}")
        assert next_descriptor() == before
        clients[1].settimeout(0.1)
        assert clients[0].recv(1) == b""
        with pytest.raises(TimeoutError):
            clients[1].recv(1)
        for each in (*clients, *served):
            each.close()


def next_descriptor() -> int:
    """The lowest that is free."""
    with open(os.devnull) as file:
        return file.fileno()
