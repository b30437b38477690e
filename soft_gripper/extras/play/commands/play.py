"""soft-gripper play: runs a scenario in real time, commanded and watched in a browser."""

import argparse
import logging
from functools import partial
from pathlib import Path

from soft_gripper.commands.chosen_station import chosen_scenario, station_of
from soft_gripper.extras.play.session import Session, open_scenario
from soft_gripper.files.output import lock_folder
from soft_gripper.interrupts import held_back
from soft_gripper.page.page_server import LivePage, page_contents, page_server


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    name = Path(options.scenario).stem
    scenario = open_scenario(chosen_scenario(options), options.grip)
    folder = lock_folder(options.out or Path("results") / "play" / name)
    logging.getLogger("drake").setLevel(logging.WARNING)  # suppress the "Meshcat listening" messages
    session = Session(partial(station_of, options.scenario, scenario), folder)
    station = session.station
    fingers = [finger.name for finger in station.fingers]
    about = page_contents("play", name, scenario, session.panel, station.parts.signals, fingers)
    page = LivePage(about, session.panel, session.feed)
    with held_back() as is_interrupted, page_server(options.host, lambda: session.scene, page) as address:
        print(f"Open {address} in a browser. The 'stop' button there, or Ctrl-C here, ends the session.", flush=True)
        try:
            session.run(is_interrupted)
        finally:
            print(f"Played {session.played:.1f} s at {session.factor:.2f} times real time.")
            if page.refused:
                print(f"Rejected {page.refused} messages that were not valid commands.")
            print("Recordings:", ", ".join(map(str, session.recordings)) or "none.", flush=True)
