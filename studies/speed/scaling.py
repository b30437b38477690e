"""Measures the cost against segments, fingers, objects, sections and runs: a table, and docs/scaling.png and .svg.

Two free fingers through one step of pressure; one thing is varied at a time. CPU time of a simulated second, of the
plant with its drive alone and with sensing and estimation, logs included; of runs in MuJoCo, whole runs. Medians of
alternating runs.
"""

import argparse
from collections.abc import Callable
from copy import deepcopy

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from soft_gripper import ModelConfig, Scenario, load_scenario
from soft_gripper.pictures.style import STYLE, estimator_style, save_figure
from studies import ROOT
from studies.peers import engine_peer, ours
from studies.peers.task import PeerTask, Run

FIGURE = ROOT / "docs" / "scaling"
OVERRIDES = ["pressure.steps.all=[60e3]", "pressure.settle=1.0", "pressure.hold_samples=100"]
ROUNDS = 5
SPACING = 0.12  # m, between fingers and between boxes
FLOOR = -0.3  # m, height of the table, which no finger reaches


def set_segments(scenario: Scenario, number: int) -> None:
    """Gives the fingers a number of segments."""
    for model in scenario.models:
        model.segments = number


def set_fingers(scenario: Scenario, number: int) -> None:
    """Puts a number of fingers side by side."""
    scenario.models = [deepcopy(scenario.models[0]) for _ in range(number)]
    for place, model in enumerate(scenario.models):
        model.name = f"finger_{place}"
        model.X_PC.translation = np.array([0, SPACING * place, 0.2])


def add_objects(scenario: Scenario, number: int) -> None:
    """Adds a number of boxes that rest on a table."""
    scenario.models.append(ModelConfig("table", "package://soft_gripper/objects/table.sdf", child="surface"))
    scenario.models[-1].X_PC.translation = np.array([0, 0, FLOOR])
    for place in range(number):
        box = ModelConfig(f"box_{place}", "package://soft_gripper/objects/box.sdf", free=True)
        box.X_PC.translation = np.array([SPACING * (place % 4 - 1.5), SPACING * (place // 4 - 0.5), FLOOR + 0.03001])
        scenario.models.append(box)


def set_sections(scenario: Scenario, number: int) -> None:
    """Sets the number of strain sensors along each side of a finger."""
    scenario.sensor.sections = number


VARIED: dict[str, tuple[Callable[[Scenario, int], None], tuple[int, ...]]] = {
    "segments of a finger": (set_segments, (6, 12, 24, 48, 96)),
    "fingers": (set_fingers, (1, 2, 3, 4, 5)),
    "objects on a table": (add_objects, (0, 1, 2, 4, 8)),
    "sections of a side": (set_sections, (1, 2, 3, 4, 6, 12)),
}
AT_ONCE = "runs at once, in MuJoCo"
RUNS = (1, 4, 16, 64, 256)
Costs = dict[str, np.ndarray]  # by variation, (values, 2) s for a simulated second: plant alone, with sensing


def run(options: argparse.Namespace) -> None:
    """Prints the table and draws the figure."""
    costs = {name: measure_costs(values, drake_runs(vary)) for name, (vary, values) in VARIED.items()}
    costs[AT_ONCE] = measure_costs(RUNS, mujoco_run)
    print("| varied | | plant and drive [ms] | with sensing [ms] |\n|---|---:|---:|---:|")
    for name, seconds in costs.items():
        for value, (plant_time, sensed) in zip(varied_values(name), 1e3 * seconds, strict=True):
            print(f"| {name} | {value} | {plant_time:.1f} | {sensed:.1f} |")
    draw(costs)


def drake_runs(vary: Callable[[Scenario, int], None]) -> Callable[[int, bool], Run]:
    """Function that makes the runs of a varied value, without sensing or with it."""

    def make(value: int, sensed: bool) -> Run:
        scenario = load_scenario("free_bending", OVERRIDES)
        vary(scenario, value)
        return ours.make_run(PeerTask(scenario, sensed), {})

    return make


def mujoco_run(number: int, sensed: bool) -> Run:
    """Makes a number of runs at once, whose estimates are computed if they are read."""
    return engine_peer.make_run(PeerTask(load_scenario("free_bending", OVERRIDES), sensed), {"runs": number})


def measure_costs(values: tuple[int, ...], make: Callable[[int, bool], Run]) -> np.ndarray:
    """CPU time of a simulated second, (values, 2) s."""
    runs = [make(value, sensed) for value in values for sensed in (False, True)]
    seconds = np.median([[run().seconds for run in runs] for _ in range(ROUNDS)], axis=0)
    return seconds.reshape(-1, 2) / load_scenario("free_bending", OVERRIDES).duration


def varied_values(name: str) -> tuple[int, ...]:
    """Values of a variation."""
    return RUNS if name == AT_ONCE else VARIED[name][1]


def draw(costs: Costs) -> None:
    """Draws a panel for each varied quantity."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(12, 2.8), layout="constrained")
        for axes, (name, seconds) in zip(figure.subplots(1, len(costs), sharey=True), costs.items(), strict=True):
            values = varied_values(name)
            for place, label in enumerate(("plant and drive", "with sensing")):
                axes.plot(values, 1e3 * seconds[:, place], **estimator_style(place + 1, label))
            axes.set(xlabel=name, yscale="log")
            if name.startswith("segments"):
                axes.set(ylabel="computing time of a\nsimulated second [ms]")
                axes.legend(frameon=False)
            if name.startswith("segments") or name == AT_ONCE:
                axes.set(xscale="log")
            axes.set_xticks(values, labels=map(str, values))
            axes.xaxis.set_minor_locator(NullLocator())
        save_figure(figure, FIGURE)
