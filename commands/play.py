"""soft-gripper play: a scenario in real time, commanded and watched in a browser."""

import argparse
import logging
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from soft_gripper.commands.terminal.options import add_scenario_options, chosen_scenario, station_of
from soft_gripper.commands.terminal.paths import path
from soft_gripper.commands.terminal.subparsers import Subparsers, add_command
from soft_gripper.diagrams.live.control_panel import BUTTON_KEYS
from soft_gripper.diagrams.live.open_scenario import GRIPS, open_scenario
from soft_gripper.diagrams.live.page_server import page_server
from soft_gripper.diagrams.live.plots import first_plots, plots_of
from soft_gripper.diagrams.live.recorder import Recorder
from soft_gripper.diagrams.live.session import Session
from soft_gripper.diagrams.live.signal_feed import SignalFeed
from soft_gripper.diagrams.live.sliders import Slider
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.open_meshcat import open_meshcat
from soft_gripper.folder_claims import claim_folder

ADDRESS = "127.0.0.1"
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
    parser.add_argument(
        "--host",
        metavar="ADDRESS",
        default=ADDRESS,
        help=f"who can open the page; default: {ADDRESS}, this machine alone; 0.0.0.0: whoever reaches it",
    )
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    name = Path(options.scenario).stem
    scenario = open_scenario(chosen_scenario(options), options.grip)
    folder = claim_folder(options.out or Path("results") / "play" / name)
    logging.getLogger("drake").setLevel(logging.WARNING)  # the address is Meshcat's alone
    meshcat = open_meshcat(options.host)
    station = station_of(options.scenario, scenario, meshcat)
    feed = SignalFeed(station.parts.signals)
    session = Session(station, meshcat, feed, Recorder(station, meshcat, folder))
    with page_server(_about(name, station, session.sliders), meshcat, feed, options.host) as port:
        shown = "localhost" if options.host == ADDRESS else options.host
        print(f"Open http://{shown}:{port} in a browser. Its button 'stop', or Ctrl-C here, ends.", flush=True)
        try:
            session.run()
        finally:
            print(f"Played {session.played:.1f} s at {session.factor:.2f} times real time.", flush=True)


def _about(name: str, station: Station, sliders: Iterable[Slider]) -> dict[str, Any]:
    """What the page is told: the scenario, the plots, and which keys do what."""
    plots = plots_of(station.parts.signals, [finger.name for finger in station.fingers])
    keys = [[slider.name, *map(_sign, slider.keys)] for slider in sliders if any(slider.keys)]
    return {
        "name": name,
        "description": station.scenario.description,
        "plots": plots,
        "shown": first_plots(plots),
        "keys": [*keys, *([button, _sign(key)] for button, key in BUTTON_KEYS.items() if key)],
    }


def _sign(key: str) -> str:
    """What is printed on a key."""
    return _SIGNS.get(key, key.removeprefix("Key"))
