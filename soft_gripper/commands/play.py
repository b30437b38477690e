"""soft-gripper play: a scenario in real time, commanded and watched in a browser."""

import argparse
import logging
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Any

from soft_gripper.commands.terminal.options import (
    Subparsers,
    add_command,
    add_scenario_options,
    chosen_scenario,
    path,
    station_of,
)
from soft_gripper.commands.terminal.viewing import add_host_option
from soft_gripper.files.output import claim_folder
from soft_gripper.play.control_panel import BUTTON_KEYS
from soft_gripper.play.interrupts import held_back
from soft_gripper.play.open_scenario import GRIPS, open_scenario
from soft_gripper.play.page_server import LivePage, page_server
from soft_gripper.play.plots import first_plots, plots_of
from soft_gripper.play.session import Session

_SIGNS = {"ArrowUp": "\N{UPWARDS ARROW}", "ArrowDown": "\N{DOWNWARDS ARROW}", "Comma": ",", "Period": "."}


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        "play",
        "move the gripper yourself, live in a browser",
        "box_grasp                        pressures by sliders and keys",
        "tip_distance_steps               the opening, held by its controller",
        "pick_and_place_box --grip pressure --set sensor.sections=2",
    )
    add_scenario_options(parser, default="box_grasp")
    parser.add_argument(
        "--grip", choices=GRIPS, help="what the sliders command; default: the opening where the scenario holds one"
    )
    parser.add_argument("--out", metavar="DIR", type=path, help="of the recordings; default: results/play/SCENARIO")
    add_host_option(parser)
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    name = Path(options.scenario).stem
    scenario = open_scenario(chosen_scenario(options), options.grip)
    folder = claim_folder(options.out or Path("results") / "play" / name)
    logging.getLogger("drake").setLevel(logging.WARNING)  # the address of Meshcat is not one to open
    session = Session(partial(station_of, options.scenario, scenario), folder)
    page = LivePage(_about(name, session), session.panel, session.feed)
    with held_back() as is_interrupted, page_server(options.host, lambda: session.scene, page) as address:
        print(f"Open {address} in a browser. Its button 'stop', or Ctrl-C here, ends.", flush=True)
        try:
            session.run(is_interrupted)
        finally:
            print(f"Played {session.played:.1f} s at {session.factor:.2f} times real time.")
            if page.refused:
                print(f"Refused: {page.refused} messages that were not commands.")
            print("Recordings:", ", ".join(map(str, session.recordings)) or "none.", flush=True)


def _about(name: str, session: Session) -> dict[str, Any]:
    """What the page shows from the beginning: the scenario, the controls and the plots that can be chosen."""
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


def _sign(key: str) -> str:
    """What is printed on a key."""
    return _SIGNS.get(key, key.removeprefix("Key"))
