"""soft-gripper play: runs a scenario in real time, commanded and watched in a browser."""

import argparse
from functools import partial
from pathlib import Path

from soft_gripper.commands.chosen_station import station_of
from soft_gripper.extras.page.session import Session, serve_session
from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.extras.play.simulation_driver import SimulationDriver
from soft_gripper.files.output import lock_folder
from soft_gripper.interrupts import held_back


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenario = open_scenario(options.chosen_scenario, options.grip)
    folder = lock_folder(options.out or Path("results") / "play" / Path(options.scenario).stem)
    driver = SimulationDriver(partial(station_of, options.scenario, scenario))
    say = partial(print, flush=True)
    with held_back() as is_interrupted:
        serve_session(Session(driver, folder), "play", options, scenario, is_interrupted, say)
