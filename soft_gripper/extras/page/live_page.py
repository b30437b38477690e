"""The page of a session: its files, its contents, and the commands that it accepts."""

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import asdict
from itertools import product
from pathlib import Path
from typing import Any

from pydrake.systems.framework import OutputPort

from soft_gripper.errors import InputError
from soft_gripper.extras.page.panel import Panel
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.files.json_text import parse_json
from soft_gripper.scenario.schema import Scenario
from soft_gripper.signals import signal_of

_FILES_FOLDER = Path(__file__).parent / "files"
_PAGE_FILES = {
    "": ("index.html", "text/html; charset=utf-8"),
    "page.js": ("page.js", "text/javascript; charset=utf-8"),
    "controls.js": ("controls.js", "text/javascript; charset=utf-8"),
    "plot.js": ("plot.js", "text/javascript; charset=utf-8"),
    "page.css": ("page.css", "text/css; charset=utf-8"),
}


class SessionPage:
    """The data that the page of a session shows, and the commands it accepts."""

    def __init__(self, contents: Mapping[str, Any], panel: Panel, feed: SignalFeed):
        """`contents` is sent to the page once, as JSON, and `feed` continuously; commands go to `panel`."""
        self.about, self.panel, self.feed = contents, panel, feed
        self.refused = 0  # messages that were not valid commands

    def file(self, path: str) -> tuple[str, bytes] | None:
        if path == "about.json":
            return "application/json", json.dumps(self.about).encode()
        if path not in _PAGE_FILES:
            return None
        name, kind = _PAGE_FILES[path]
        return kind, (_FILES_FOLDER / name).read_bytes()

    def listen(self, listener: Callable[[str], None]) -> None:
        self.feed.listen(listener)

    def take(self, message: str | bytes, listener: Callable[[str], None]) -> None:
        """Takes a command, `{"signals": [NAME, ...]}`, those sent from now on, or `{"seen": NUMBER}` of a message."""
        try:
            command = parse_json("page", message)
        except InputError:
            command = None
        match command:
            case {"signals": [*names]} if all(isinstance(name, str) and name in self.feed.signals for name in names):
                self.feed.listen(listener, names)
            case {"seen": int(number), **rest} if not rest:
                self.feed.see(listener, number)
            case _:
                self.refused += not self.panel.take(command)

    def leave(self, listener: Callable[[str], None]) -> None:
        self.feed.leave(listener)


MAX_LINES = 16  # of a signal
# Plots at first, if there are such signals: a contact force, estimated if possible, then others.
_FORCE_SIGNALS = ("transverse_force", "normal_force")
SHOWN = ("pressure", "tension", "grip.opening", "external_torque", "theta", "strain")
_INITIAL_PLOTS = 3
_KEY_SIGNS = {"ArrowUp": "\N{UPWARDS ARROW}", "ArrowDown": "\N{DOWNWARDS ARROW}", "Comma": ",", "Period": "."}
_DISPLAY_UNITS = {"Pa": (1e-3, "kPa"), "m": (1e3, "mm"), "rad": (180 / math.pi, "deg"), "N m": (1e3, "mN m")}


def page_contents(
    command: str,
    name: str,
    scenario: Scenario,
    panel: Panel,
    signals: Mapping[str, OutputPort],
    fingers: Collection[str],
) -> dict[str, Any]:
    """The data sent to the page of a command when it is opened; for `signals` and `fingers` see `list_plots`."""
    plots = list_plots(signals, fingers)
    return {
        "command": command,
        "name": name,
        "description": scenario.description,
        "plots": plots,
        "shown": first_plots(plots),
        "sliders": [{**asdict(slider), "signs": [*map(_key_label, slider.keys)]} for slider in panel.sliders],
        "buttons": [{"name": button, "key": key, "sign": _key_label(key)} for button, key in panel.buttons.items()],
    }


def list_plots(signals: Mapping[str, OutputPort], fingers: Collection[str]) -> dict[str, dict[str, Any]]:
    """The available plots by title; signals of the fingers share one.

    Returns:
        `unit`, `scale` from the port's unit to it, `axes` of the entries, and `signals`, the labels of their entries by
        their names.
    """
    plots: dict[str, dict[str, Any]] = {}
    for name, port in signals.items():
        owner, _, signal_name = name.rpartition(".")
        if port.size() <= MAX_LINES:
            scale, unit = _display_unit(signal_of(port).unit)
            kind = signal_name if owner in fingers else name
            axes = signal_of(port).axes
            plot = plots.setdefault(kind, {"unit": unit, "scale": scale, "axes": " ".join(axes), "signals": {}})
            plot["signals"][name] = [" ".join(map(str, entry)) for entry in product(*axes.values())]
    return dict(sorted(plots.items(), key=lambda item: ("." in item[0], item[0])))


def first_plots(plots: Iterable[str]) -> list[str]:
    """The plots shown by default."""
    titles = set(plots)
    forces = [name for name in _FORCE_SIGNALS if name in titles]
    return [*forces[:1], *(name for name in SHOWN if name in titles)][:_INITIAL_PLOTS]


def _display_unit(unit: str | tuple[str, ...]) -> tuple[float, str]:
    """A display unit and the conversion factor to it; several units are listed."""
    if isinstance(unit, tuple):
        return 1.0, ", ".join(dict.fromkeys(unit))
    return _DISPLAY_UNITS.get(unit, (1.0, unit))


def _key_label(key: str) -> str:
    """Label of a key on its button."""
    return _KEY_SIGNS.get(key, key.removeprefix("Key"))
