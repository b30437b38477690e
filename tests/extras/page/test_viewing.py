"""A run whose scene is shown in a browser, and the wait at its end."""

import io
import os
import socket
import sys

import pytest
from command_line import short, soft_gripper

from soft_gripper.diagrams.view.meshcat_view import LOOPBACK
from soft_gripper.extras.page.viewing import cut_off, wait_for_viewer


def test_a_run_is_shown_while_it_lasts(monkeypatch, tmp_path) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    outcome = soft_gripper("run", "free_bending", *short(), "--meshcat", "--out", tmp_path)
    assert outcome.code == 0
    assert outcome.err.startswith("Open http://")
    assert "so Meshcat closes now" in outcome.out


@pytest.mark.parametrize("stdin", [None, io.StringIO("")])
def test_no_terminal_to_wait_at(stdin: io.StringIO | None, monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "stdin", stdin)
    wait_for_viewer()
    assert "no terminal" in capsys.readouterr().out


def test_the_end_of_input_ends_waiting(monkeypatch, capsys) -> None:
    class AtEnd(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stdin", AtEnd(""))
    wait_for_viewer()
    assert "Press Enter" in capsys.readouterr().out


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
