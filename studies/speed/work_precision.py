"""Error of the fingertips against computing time for both solvers: tables, and docs/work_precision.png and .svg.

The closed diagram, as users run it, goes through four steps of pressure. The reference is radau3, whose time
stepping has nothing in common with either solver. The difference of the discrete plant with its step taken to zero
(Richardson extrapolation from 0.2 and 0.1 ms) from it is a bound of its error.
"""

import argparse
from time import process_time
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator

from soft_gripper.arrays import Planar
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.pictures.style import STYLE
from soft_gripper.scenario.scenario_file import load_scenario
from studies import ROOT

MOVING, SETTLED = (50, 100)  # samples: the first after every step of pressure, and the last before the next
INPUT_CHANGES = [
    "pressure.steps.all=[60e3, 150e3, -30e3, 90e3]",
    f"pressure.hold_samples={SETTLED}",
    "pressure.settle=1.0",
]
NO_LAG_CHANGES = ["pressure.time_constant=0.0"]
REPEATS = 9
FIGURE = ROOT / "docs" / "work_precision"


def discrete(step_ms: float) -> list[str]:
    """Changes for the discrete plant."""
    return [f"plant_config.time_step={step_ms / 1e3}"]


def continuous(scheme: str, accuracy: float = 1e-3, max_step_ms: float = 20.0, control: bool = True) -> list[str]:
    """Changes for the continuous plant under one of Drake's integrators."""
    config = {
        "integration_scheme": scheme,
        "accuracy": accuracy,
        "max_step_size": max_step_ms / 1e3,
        "use_error_control": str(control).lower(),
    }
    return ["plant_config.time_step=0.0", *(f"simulator_config.{key}={value}" for key, value in config.items())]


REFERENCE = continuous("radau3", 1e-4)
ACCURACIES = {"10⁻²": 1e-2, "10⁻³": 1e-3, "10⁻⁴": 1e-4, "10⁻⁵": 1e-5}
SETTINGS = {  # (solver, setting) -> overrides
    **{("discrete", f"{step} ms"): discrete(step) for step in (10, 5, 2, 1)},
    **{("cenic, accuracy", name): continuous("cenic", accuracy) for name, accuracy in ACCURACIES.items()},
    **{("cenic, fixed step", f"{step} ms"): continuous("cenic", max_step_ms=step, control=False) for step in (10, 1)},
}
DEFAULT = ("discrete", "10 ms")
STYLES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {  # of lines, and of the labels beside their points
    "discrete": ({"color": "#2166ac", "marker": "o"}, {"xytext": (-6, -4), "ha": "right", "va": "top"}),
    "cenic, accuracy": ({"color": "#b2182b", "marker": "s"}, {"xytext": (6, 3), "ha": "left", "va": "bottom"}),
    "cenic, fixed step": (
        {"color": "#7f7f7f", "marker": "^", "lw": 0},
        {"xytext": (7, 0), "ha": "left", "va": "center"},
    ),
}


class SolverResult(NamedTuple):
    """Cost of a solver, and error of its fingertips."""

    seconds: float  # CPU time for a simulated second
    settled: float  # m, worst over steps and fingers of the means over the settled samples
    moving: float  # m, root mean square over the moving samples


Results = dict[tuple[str, str], SolverResult]  # by solver and setting


def run(options: argparse.Namespace) -> None:
    """Runs everything, prints the tables and draws the figure."""
    seconds, reference = timed_tips(make(REFERENCE))
    results = measure(reference)
    extrapolated = 2 * timed_tips(make(discrete(0.1)))[1] - timed_tips(make(discrete(0.2)))[1]
    print_results(results)
    default = results[DEFAULT].seconds
    settled_error, moving_error = errors(extrapolated, reference)
    print(f"\nComputing time 1 is {1e3 * default:.0f} ms for a simulated second, no signal read.")
    print(f"The reference takes {seconds / default:.0f}.")
    distances = f"{1e6 * settled_error:.4f} µm and {1e3 * moving_error:.5f} mm"
    print(f"The discrete plant towards 0 ms is {distances} from the reference.\n")
    print_floor(reference)
    draw(results)


def measure(reference: Planar) -> Results:
    """Runs all settings alternately, so that a busy machine slows them equally; the computing times are medians."""
    stations = {key: make(overrides) for key, overrides in SETTINGS.items()}
    repeats = [{key: timed_tips(station) for key, station in stations.items()} for _ in range(REPEATS)]
    results = {}
    for key in stations:
        seconds = float(np.median([repeat[key][0] for repeat in repeats]))
        results[key] = SolverResult(seconds, *errors(repeats[0][key][1], reference))
    return results


def make(overrides: list[str]) -> Station:
    """Makes the closed diagram under the solver that the overrides choose."""
    return make_private_station(load_scenario("free_bending", [*INPUT_CHANGES, *overrides]))


def timed_tips(station: Station) -> tuple[float, Planar]:
    """CPU time for a simulated second, s, no signal read, and tips in their frames B, (fingers, steps, samples) m."""
    start = process_time()
    recording = run_station(station)
    seconds = (process_time() - start) / station.scenario.duration
    tips = [
        forward_kinematics(recording[f"{f.name}.sampled_joint_angles"].values, f.finger.segment_length).tip
        for f in station.fingers
    ]
    return seconds, np.array(tips)[:, 1:].reshape(len(tips), station.scenario.steps, -1)


def errors(tips: Planar, reference: Planar) -> tuple[float, float]:
    """Error of the settled and of the moving fingertips, m."""
    difference = tips - reference
    settled_error = np.abs(difference[..., -SETTLED:].mean(axis=-1)).max()
    moving_error = np.sqrt((np.abs(difference[..., :MOVING]) ** 2).mean())
    return float(settled_error), float(moving_error)


def print_results(results: Results) -> None:
    """Prints all results as a Markdown table."""
    default = results[DEFAULT].seconds
    print("| solver | setting | computing time | settled tip [µm] | moving tip [mm] |")
    print("|---|---|---:|---:|---:|")
    for key, (seconds, settled_error, moving_error) in results.items():
        print(f"| {' | '.join(key)} | {seconds / default:.1f} | {1e6 * settled_error:.3f} | {1e3 * moving_error:.3f} |")


def print_floor(reference: Planar) -> None:
    """Prints the errors of cenic while the tip moves: shorter steps, an input without lag, and the shipped settings."""
    without_lag = timed_tips(make([*REFERENCE, *NO_LAG_CHANGES]))[1]
    print("Moving tip under cenic [mm]\n")
    print("| accuracy | steps up to 10 ms | up to 1 ms | up to 10 ms, no pressure lag |")
    print("|---|---:|---:|---:|")
    for name, accuracy in ACCURACIES.items():
        usual_steps, short_steps = continuous("cenic", accuracy), continuous("cenic", accuracy, max_step_ms=1.0)
        runs = ((usual_steps, reference), (short_steps, reference), ([*usual_steps, *NO_LAG_CHANGES], without_lag))
        moving_errors = [1e3 * errors(timed_tips(make(overrides))[1], truth)[1] for overrides, truth in runs]
        print(f"| {name} | " + " | ".join(f"{error:.3f}" for error in moving_errors) + " |")


def draw(results: Results) -> None:
    """Draws a panel for the settled and one for the moving tip, a line per solver, a point per setting."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 4), layout="constrained")
        settled_axes, moving_axes = figure.subplots(1, 2, sharex=True)
        _draw_panel(settled_axes, results, "settled", 1e6)
        _draw_panel(moving_axes, results, "moving", 1e3)
        settled_axes.set(title="Settled fingertip", ylabel="worst error [µm]")
        moving_axes.set(title="Moving fingertip", ylabel="rms error in the 0.5 s after a step [mm]")
        moving_axes.legend(frameon=False)
        for suffix, metadata in ((".png", None), (".svg", {"Date": None})):
            figure.savefig(FIGURE.with_suffix(suffix), dpi=150, metadata=metadata)


def _draw_panel(axes: Axes, results: Results, error: str, scale: float) -> None:
    for solver, (line, label) in STYLES.items():
        settings = {name: result for (key, name), result in results.items() if key == solver}
        x = [1e3 * result.seconds for result in settings.values()]
        y = [scale * getattr(result, error) for result in settings.values()]
        axes.plot(x, y, ms=6, **{"lw": 1.5, **line}, label=solver)
        for name, point in zip(settings, zip(x, y, strict=True), strict=True):
            axes.annotate(name, point, textcoords="offset points", color=line["color"], fontsize="small", **label)
    axes.set(xscale="log", yscale="log", xlabel="computing time per simulated second [ms]")
    axes.margins(0.15)
    for axis, ticks in ((axes.xaxis, (1, 1.5, 2, 3, 5, 7)), (axes.yaxis, (1, 2, 5) if scale == 1e3 else (1,))):
        axis.set_major_locator(LogLocator(subs=ticks))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_locator(NullLocator())
