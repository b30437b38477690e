"""A station that is played, and somebody at its Meshcat."""

import struct

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.live.open_scenario import open_scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station


def played(name: str, grip: str | None = None, *overrides: str) -> tuple[Station, Meshcat]:
    """The station of a shipped scenario with its commands left open, and what shows it."""
    meshcat = Meshcat()
    return make_station(open_scenario(load_scenario(name, overrides), grip), meshcat), meshcat


def click(meshcat: Meshcat, button: str) -> None:
    """Clicks a button, as a browser says it."""
    meshcat._InjectWebsocketMessage(_packed({"type": "button", "name": str(button)}))


def move(meshcat: Meshcat, slider: str, value: float) -> None:
    """Moves a slider, as a browser says it."""
    meshcat._InjectWebsocketMessage(_packed({"type": "slider", "name": slider, "value": value}))


def _packed(message: dict[str, str | float]) -> bytes:
    """MessagePack of a few short texts and numbers."""
    pieces = [bytes([0x80 | len(message)])]
    for entry in (each for item in message.items() for each in item):
        if isinstance(entry, str):
            pieces.append(b"\xd9" + bytes([len(entry)]) + entry.encode())
        else:
            pieces.append(b"\xcb" + struct.pack(">d", entry))
    return b"".join(pieces)
