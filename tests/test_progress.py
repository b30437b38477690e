"""The progress of a run that takes long, for who waits at a terminal or in a notebook."""

import sys
from io import StringIO
from types import ModuleType, SimpleNamespace

import pytest
from finger_plants import free_bending

import soft_gripper as sg
from soft_gripper import progress


class Screen(StringIO):
    """An error stream, on a terminal or not."""

    def __init__(self, is_terminal: bool):
        super().__init__()
        self.isatty = lambda: is_terminal


def shown(monkeypatch, is_terminal, delay=0.0, **options):
    """What a short run says on standard error."""
    screen = Screen(is_terminal)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(progress, "_BAR_DELAY", delay)
    sg.simulate(free_bending([0.0, 50e3], 0.5), **options)
    return screen.getvalue()


def test_a_terminal_shows_the_simulated_time(monkeypatch):
    text = shown(monkeypatch, True)
    assert "/1 s simulated [" in text
    assert text.endswith(" \r")  # it is wiped


def test_who_takes_the_progress_shows_it(monkeypatch):
    times = []
    assert shown(monkeypatch, True, progress=times.append) == ""
    assert times[-1] == pytest.approx(1.0)


@pytest.mark.parametrize(("shell", "has_bar"), [({"kernel": "ipykernel"}, True), ({}, False)])
def test_a_notebook_shows_it_without_a_terminal(shell, has_bar, monkeypatch):
    ipython = ModuleType("IPython")
    ipython.get_ipython = lambda: SimpleNamespace(**shell)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    assert ("/1 s simulated [" in shown(monkeypatch, False)) == has_bar
