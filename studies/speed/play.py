"""Measures the speed of `soft-gripper play` relative to real time.

Every scenario is played for TIME: the fingers close and open again, and an arm lowers its tool. Meshcat and the plots
are sent everything, with no browser to show them. Exit code 1: a scenario stays below BAR.
"""

import argparse
import logging
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from soft_gripper import load_scenario, make_station
from soft_gripper.diagrams.view.meshcat_view import PERIOD
from soft_gripper.extras.page.panel import Slider
from soft_gripper.extras.page.session import Session
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.extras.play.simulation_driver import SimulationDriver
from soft_gripper.scenario.shipped import scenario_names

TIME, CLOSE, OPEN, LOWER = 12.0, 2.0, 7.0, 4.0  # s, how long, and when what begins
BAR = 0.98  # of real time


class Player(SignalFeed):
    """Moves sliders at their times."""

    def __init__(self, session: Session):
        super().__init__(())
        panel = self._panel = session.driver.panel
        self.frame = 0
        self._moves = {round(time / PERIOD): (slider, value) for time, slider, value in moves(panel.sliders)}

    def send(self, status: Mapping[str, Any], values: Mapping[str, Any]) -> None:
        """Counts frames."""
        self.frame += 1
        if self.frame in self._moves:
            slider, value = self._moves[self.frame]
            self._panel.take({"slider": slider.name, "value": value})


def moves(sliders: Sequence[Slider]) -> Iterator[tuple[float, Slider, float]]:
    """Times and positions of the sliders; the first slider moves all fingers."""
    grip = sliders[0]
    yield CLOSE, grip, 0.6 * grip.value if "opening" in grip.name else (grip.low + grip.high) / 2
    yield OPEN, grip, grip.value
    yield from ((LOWER, slider, slider.value - 50.0) for slider in sliders if slider.name.startswith("tool z"))


def factor(name: str, folder: Path) -> float:
    """Simulated over real time of a scenario."""
    scenario = open_scenario(load_scenario(name))
    driver = SimulationDriver(partial(make_station, scenario))
    session = Session(driver, folder)
    session.feed = player = Player(session)
    session.run(lambda: player.frame * PERIOD >= TIME)
    return driver.pacer.whole_factor


def run(options: argparse.Namespace) -> int:
    """Prints a line per scenario."""
    logging.getLogger("drake").setLevel(logging.WARNING)  # whose log names the address of every Meshcat
    slow_count = 0
    with TemporaryDirectory() as folder:
        for name in options.scenarios or scenario_names():
            speed = factor(name, Path(folder))
            slow_count += speed < BAR
            print(f"{name:<26} {speed:.2f}{'' if speed >= BAR else f'  MISSES {BAR}'}", flush=True)
    return int(slow_count > 0)
