"""What the page of a session shows: the scenario, the sliders and buttons, and the plots that can be chosen."""

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict
from itertools import product
from typing import Any

from pydrake.systems.framework import OutputPort

from soft_gripper.play.control_panel import BUTTON_KEYS
from soft_gripper.play.session import Session
from soft_gripper.signals import signal_of

MOST_LINES = 16  # of a signal
SHOWN = ("pressure", "grip.opening", "contact_force", "external_torque", "theta", "strain")  # at first, of those
_SHOWN_AT_FIRST = 3
_SIGNS = {"ArrowUp": "\N{UPWARDS ARROW}", "ArrowDown": "\N{DOWNWARDS ARROW}", "Comma": ",", "Period": "."}
_READABLE = {"Pa": (1e-3, "kPa"), "m": (1e3, "mm"), "rad": (180 / math.pi, "deg"), "N m": (1e3, "mN m")}


def page_contents(name: str, session: Session) -> dict[str, Any]:
    """What the page is given when it is opened."""
    station = session.station
    plots = plots_of(station.parts.signals, [finger.name for finger in station.fingers])
    return {
        "name": name,
        "description": station.scenario.description,
        "plots": plots,
        "shown": first_plots(plots),
        "sliders": [{**asdict(slider), "signs": [*map(_sign, slider.keys)]} for slider in session.panel.sliders],
        "buttons": [{"name": button, "key": key, "sign": _sign(key)} for button, key in BUTTON_KEYS.items()],
    }


def plots_of(signals: Mapping[str, OutputPort], fingers: Collection[str]) -> dict[str, dict[str, Any]]:
    """The plots that can be chosen, by what they show; signals of the fingers share one.

    Returns:
        `unit`, `scale` from the port's unit to it, and `signals`, the labels of their entries by their names.
    """
    found: dict[str, dict[str, Any]] = {}
    for name, port in signals.items():
        owner, _, own = name.rpartition(".")
        if port.size() <= MOST_LINES:
            scale, unit = _readable(signal_of(port).unit)
            kind = own if owner in fingers else name
            plot = found.setdefault(kind, {"unit": unit, "scale": scale, "signals": {}})
            plot["signals"][name] = [" ".join(map(str, entry)) for entry in product(*signal_of(port).axes.values())]
    return dict(sorted(found.items(), key=lambda item: ("." in item[0], item[0])))


def first_plots(plots: Iterable[str]) -> list[str]:
    """The plots that are shown before anybody has chosen."""
    return [name for name in SHOWN if name in set(plots)][:_SHOWN_AT_FIRST]


def _readable(unit: str | tuple[str, ...]) -> tuple[float, str]:
    """A unit that people read, and the factor into it; of several units, what they are."""
    if isinstance(unit, tuple):
        return 1.0, ", ".join(dict.fromkeys(unit))
    return _READABLE.get(unit, (1.0, unit))


def _sign(key: str) -> str:
    """What is printed on a key."""
    return _SIGNS.get(key, key.removeprefix("Key"))
