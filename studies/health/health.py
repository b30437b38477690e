"""Detected and named faults of sensors and fingers, their delays, and false alarms.

Half of the runs have one fault. Every run is simulated by itself, with a scenario, pressures, supply, object place and
sensor errors of its own, and lasts 12 s. The monitor assumes an exact nominal model, which it is; some runs are
monitored again with a wrong nominal stiffness, and with a larger uncertainty.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.estimators.uncertainty import uncertainty_of
from soft_gripper.extras.health.faults import FAULTS
from soft_gripper.extras.health.health_filter import WINDOW_SAMPLES, HealthFilter
from soft_gripper.extras.health.health_monitor import named_fault
from soft_gripper.extras.sweeps.study import results
from soft_gripper.files.row_table import print_rows
from soft_gripper.pictures.style import COLORS, STYLE, save_figure
from soft_gripper.runs.scores.readings import ReadAgain, read_again
from soft_gripper.scenario.finger_changes import changed_finger
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors
from soft_gripper.sensors.strain_errors import SENSOR_FAULTS, SensorFault, StrainErrors, disturb
from studies.kept_rows import counted_jobs

TABLE, RUNS, FIGURE = "health.csv", "health_runs.csv", "health"
PRESET = "realistic"
SECTIONS = 4
KINDS = (*SENSOR_FAULTS, "leak", "cut", "held")  # simulated faults
NAMES = {"offset": "slipped", "loose": "slipped"}  # names of simulated faults, if different
# Pressure ranges of the motions, kPa; a run draws one.
MOTIONS = {
    "free_bending": (-30, 150),
    "obstructed_inside": (0, 75),
    "obstructed_outside": (-45, 40),
    "box_grasp": (0, 140),
    "irregular_grasp": (0, 120),
}
STEPS, STEP = 12, 1.0  # of pressure, s
ONSET = 2.0, 7.0  # s
MIN_EFFECT = 0.01  # of the extension ratio, minimum of the largest change by a sensor's fault
SIZES = {"offset": (0.02, 0.08), "loose": (0.4, 0.9), "drifting": (0.005, 0.02), "saturated": (0.4, 0.75)}
HELD_PRESSURE = 150  # kPa, the highest pressure of a held finger
LEAKS, SOFTENING, CUT_LOCATIONS = (0.25, 0.6), (2.0, 3.0), (0.25, 0.7)
_MAX_DRAWS = 100
BELIEF_INTERVAL = 4  # runs, of which one is also monitored with other beliefs


@dataclass(frozen=True)
class Belief:
    """Assumptions of a monitor."""

    stiffness_error: float = 0.0  # of the nominal finger, as a fraction; positive: too stiff
    declared: float = 0.005  # uncertainty of the bend per pressure, as a fraction


EXACT = Belief()
DECLARED = tuple(Belief(error, 0.1) for error in (0.0, 0.1, -0.1))
# For fingers without a fault: errors beyond the declared uncertainty.
BEYOND = tuple(Belief(error, declared) for declared in (0.005, 0.05) for error in (0.05, -0.05, 0.1, -0.1))


@dataclass(frozen=True)
class HealthRun:
    """One run, monitored with one belief."""

    belief: str  # stiffness error and uncertainty, in percent
    number: int
    fault: str  # as simulated, or "none"
    motion: str
    finger: str
    reading: int  # -1: none
    onset: float  # s; 0 if present from the beginning; NaN without a fault
    size: float
    is_found: bool  # whether anything was named after the onset
    false_alarm: bool  # or before it
    delay: float  # s, NaN if not found
    said: str  # most probable at the end, or "healthy"

    @property
    def is_right(self) -> bool:
        """Whether the fault named at the end is true."""
        return self.is_found and self.said == NAMES.get(self.fault, self.fault)


@dataclass(frozen=True)
class HealthRow:
    """Summary of all runs with one fault, or with none, monitored with one belief."""

    belief: str
    fault: str
    runs: int
    found_percent: Annotated[float, ".3g"]
    right_percent: Annotated[float, ".3g"]
    false_alarm_percent: Annotated[float, ".3g"]
    median_delay: Annotated[float, ".3g"]  # s
    delay_90: Annotated[float, ".3g"]  # s, within which 90 % of those found are found


def run(options: argparse.Namespace) -> None:
    """Makes as many runs with a fault, of every kind in turn, as without."""
    out, console = options.out, options.console
    calls = [*_calls(options, KINDS, DECLARED), *_calls(options, ["none"], DECLARED + BEYOND)]
    jobs = {call[:2]: call for call in calls}
    with counted_jobs(options, len(jobs), "runs", "nothing is written until the last run") as (executor, ended):
        runs = [health_run for job in results(executor, run_health, jobs, ended).values() for health_run in job]
    rows = health_rows(runs)
    console.table("runs", runs, out / RUNS)
    console.table("health", rows, out / TABLE)
    save_figure(health_figure(runs), out / FIGURE)
    print_rows(rows, "by stiffness that the monitor believes, and its declared uncertainty")
    console.wrote(*(out / file for file in (TABLE, RUNS, f"{FIGURE}.png", f"{FIGURE}.svg")))


def _calls(options: argparse.Namespace, kinds: Sequence[str], rest: Sequence[Belief]) -> Iterator[tuple[Any, ...]]:
    """Arguments of `run_health` for every run."""
    for i in range(options.runs):
        is_chosen = i // len(kinds) % BELIEF_INTERVAL == 0
        yield i, kinds[i % len(kinds)], options.seed, (EXACT, *rest) if is_chosen else (EXACT,)


def moved_scenario(rng: np.random.Generator, kind: str, motion: str, overrides: Sequence[str]) -> Scenario:
    """Scenario with the pressures of a run."""
    low, high = (0, HELD_PRESSURE) if kind == "held" else MOTIONS[motion]
    steps = [0.0, *(1e3 * rng.uniform(low, high, STEPS - 1)).round().tolist()]
    common = [f"pressure.steps.all={steps}", f"pressure.settle={STEP - 0.1}", "pressure.hold_samples=10"]
    common += [f"pressure.time_constant={rng.uniform(0.05, 0.25):.3f}", "record.truth=forces"]
    if motion in ("obstructed_inside", "obstructed_outside"):
        x, gap = {"obstructed_inside": (-0.0245, 2e-3), "obstructed_outside": (-0.0655, -2e-3)}[motion]
        x += gap * rng.uniform()
        common.append(f"models.1.X_PC.translation=[{x:.4f}, 0, {rng.uniform(0.115, 0.145):.4f}]")
    return load_scenario(motion, [*common, f"sensor.sections={SECTIONS}", *overrides])


def run_health(number: int, kind: str, seed: int, beliefs: Sequence[Belief] = (EXACT,)) -> list[HealthRun]:
    """Simulates a run, and monitors its health with every belief."""
    rng = np.random.default_rng([seed, KINDS.index(kind) if kind in KINDS else len(KINDS), number])
    motion = str(rng.choice(list(MOTIONS)))
    onset = float(rng.uniform(*ONSET))
    overrides = []
    size = np.nan
    finger = None
    if kind == "leak":
        size = float(rng.uniform(*LEAKS))
        overrides = [f"pressure.leaks.all={size}", f"pressure.leak_time={onset}"]
    elif kind in ("cut", "held"):
        onset = 0.0
        motion, finger = {"cut": ("free_bending", None), "held": ("obstructed_inside", "left_finger")}[kind]
    with TemporaryDirectory() as folder:
        if kind == "cut":
            size = float(rng.uniform(*SOFTENING))
            overrides = _write_cut_finger(rng, Path(folder) / "cut.urdf", size)
        scenario = moved_scenario(rng, kind, motion, overrides)
        if kind == "held":
            _add_pegs(scenario, rng)
        station = make_private_station(scenario)
        recording = run_station(station)
        monitored = station.fingers[int(rng.integers(len(station.fingers)))]
        monitored = next((candidate for candidate in station.fingers if candidate.name == finger), monitored)
        readings_again = read_again(station, recording, monitored, SECTIONS)
    reading = -1
    errors = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=PRESET)))
    assert errors is not None
    if kind in SENSOR_FAULTS:
        fault = _sensor_fault(kind, onset, readings_again, rng)
        reading, size, errors = fault.reading, fault.size or np.nan, replace(errors, faults=(fault,))
    layout = readings_again.layout
    ratios = readings_again.layout.response.ratio(readings_again.readings)
    readings = layout.response.reading(disturb(errors, ratios, readings_again.period, rng))
    runs = []
    for belief in beliefs:
        times, probabilities = monitor_readings(readings_again, readings, errors, belief)
        is_named = named_fault(probabilities) > 0
        is_alarm = is_named & (times > (onset if kind in KINDS else np.inf))
        is_found = bool(is_alarm.any())
        runs.append(
            HealthRun(
                f"{100 * belief.stiffness_error:+.0f} % ({100 * belief.declared:g} %)",
                *(number, kind if kind in KINDS else "none", motion, monitored.name, reading),
                *(onset if kind in KINDS else np.nan, size, is_found, bool((is_named & ~is_alarm).any())),
                *(float(times[is_alarm][0] - onset) if is_found else np.nan, FAULTS[int(probabilities[-1].argmax())]),
            )
        )
    return runs


def monitor_readings(again: ReadAgain, readings: Array, errors: StrainErrors, belief: Belief) -> tuple[Array, Array]:
    """Ends of the windows of a recorded finger, (L,) s, and the probabilities of FAULTS then, (L, 8)."""
    changes = {"youngs_modulus": f"{100 * belief.stiffness_error:+g} %"}
    finger = changed_finger(again.layout.finger, "nominal", changes)
    uncertainty = replace(uncertainty_of(errors), bend_per_pressure=belief.declared)
    monitor = HealthFilter(replace(again.layout, finger=finger), uncertainty, again.period)
    memory = monitor.begin()
    probabilities = []
    for i, sample in enumerate(zip(readings, again.driving(), again.gravity, strict=True), start=1):
        memory = monitor.step(memory, *sample)
        if i % WINDOW_SAMPLES == 0:
            probabilities.append(monitor.probabilities(memory))
    return again.period * WINDOW_SAMPLES * np.arange(1, len(probabilities) + 1), np.array(probabilities)


def _sensor_fault(kind: str, onset: float, again: ReadAgain, rng: np.random.Generator) -> SensorFault:
    """A fault of a random sensor that changes its readings by MIN_EFFECT or more at some time."""
    layout = again.layout
    begin = round(onset / again.period)
    strain = layout.response.ratio(again.readings)[begin:] - 1
    for _ in range(_MAX_DRAWS):
        reading = int(rng.integers(layout.readings))
        strains = strain[:, reading]
        size = float(rng.uniform(*SIZES[kind])) if kind in SIZES else 0.0
        if kind in ("offset", "drifting"):
            size *= float(rng.choice([-1.0, 1.0]))
            return SensorFault(kind, reading, onset, size)
        if kind == "saturated":
            size *= float(strains.max())
        effects = {"dead": np.ptp(strains), "loose": size * np.abs(strains).max(), "saturated": strains.max() - size}
        if effects[kind] >= MIN_EFFECT:
            is_frozen = kind == "dead" and rng.random() < 0.5
            return SensorFault(kind, reading, onset, None if is_frozen else size)
    raise AssertionError(f"no sensor of this run sees a fault of the kind {kind}")


def _write_cut_finger(rng: np.random.Generator, file: Path, softness: float) -> list[str]:
    """Writes a finger with softer silicone from a location to the tip; the nominal finger stays as built."""
    base_uri = "package://soft_gripper/grippers/finger.urdf"
    text = model_path(base_uri).read_text()
    location = round(float(rng.uniform(*CUT_LOCATIONS)), 3)
    begin = text.index("<base")
    base = text[begin : text.index("/>", begin) + 2]
    modulus = base.split('youngs_modulus="')[1].split('"')[0]
    tip = text[text.index("<tip") : text.index("/>", text.index("<tip")) + 2]
    soft_modulus = f'youngs_modulus="{float(modulus) / softness:.6g}"'
    section = base.replace("<base", f'<section at="{location}"')
    texts = [text.replace(tip, "\n".join((section, section.replace(f'youngs_modulus="{modulus}"', soft_modulus), tip)))]
    texts.append(texts[0].replace(tip, tip.replace(f'youngs_modulus="{modulus}"', soft_modulus)))
    file.write_text(texts[1])
    return [*(f"models.{i}.file={file}" for i in range(2)), f"nominal.file={base_uri}"]


def _add_pegs(scenario: Scenario, rng: np.random.Generator) -> None:
    """Adds pegs on both sides of the left finger: inside near the tip, and outside nearer the base."""
    peg = scenario.models[1]
    for name, x, z in (("peg", -0.0245, rng.uniform(0.093, 0.097)), ("other_peg", -0.0644, rng.uniform(0.135, 0.145))):
        place = Transform(RigidTransform([x, 0.0, float(z)]))
        if name == peg.name:
            peg.X_PC = place
        else:
            scenario.models.append(replace(peg, name=name, X_PC=place))


def health_rows(runs: Sequence[HealthRun]) -> list[HealthRow]:
    """Rows of the table for every belief: each fault, all faults together, and the runs without a fault."""
    rows = []
    for belief in dict.fromkeys(run.belief for run in runs):
        belief_runs = [run for run in runs if run.belief == belief]
        groups = {kind: [run for run in belief_runs if run.fault == kind] for kind in KINDS}
        groups["all"] = [run for run in belief_runs if run.fault in KINDS]
        groups["none"] = [run for run in belief_runs if run.fault == "none"]
        rows += [_row(belief, name, group) for name, group in groups.items() if group]
    return rows


def _row(belief: str, name: str, runs: Sequence[HealthRun]) -> HealthRow:
    delays = [run.delay for run in runs if run.is_found]
    median, delay_90 = np.percentile(delays, [50, 90]) if delays else (np.nan, np.nan)
    answers = np.array([[run.is_found, run.is_right, run.false_alarm] for run in runs])
    found, right, false_alarms = (100 * answers.mean(axis=0)).tolist()
    if name == "none":
        found = right = np.nan
    return HealthRow(belief, name, len(runs), found, right, false_alarms, float(median), float(delay_90))


def health_figure(runs: Sequence[HealthRun]) -> Figure:
    """Figure of the answers to each fault, and of its delay; the model is exact."""
    runs = [run for run in runs if run.belief == runs[0].belief]
    truths = (*KINDS, "none")
    counts = np.zeros((len(truths), len(FAULTS)))
    for run in runs:
        answer = run.said if run.is_found or run.false_alarm else FAULTS[0]
        counts[truths.index(run.fault), FAULTS.index(answer)] += 1
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10, 4.2), layout="constrained")
        table, delay_plot = figure.subplots(1, 2, width_ratios=[1.35, 1])
        table.imshow(
            counts / np.maximum(counts.sum(axis=1, keepdims=True), 1), cmap="Blues", vmin=0, vmax=1, aspect="auto"
        )
        for (row, column), count in np.ndenumerate(counts):
            if count:
                dark = count > 0.6 * counts[row].sum()
                table.text(column, row, f"{count:.0f}", ha="center", va="center", color="white" if dark else "0.2")
        table.set_xticks(range(len(FAULTS)), FAULTS, rotation=30, ha="right")
        table.set_yticks(range(len(truths)), truths)
        table.tick_params(length=0)
        table.grid(visible=False)
        table.set(xlabel="named at the end", ylabel="fault of the run")
        for i, kind in enumerate(KINDS):
            delays = np.sort([run.delay for run in runs if run.fault == kind and run.is_found])
            delay_plot.plot(delays, np.full(len(delays), i), "o", ms=4, alpha=0.5, color=COLORS[1], mec="none")
            if len(delays):
                delay_plot.plot(np.median(delays), i, "|", ms=14, mew=2, color="0.15")
        delay_plot.set_yticks(range(len(KINDS)), KINDS)
        delay_plot.set_xscale("log")
        delay_plot.xaxis.set_major_formatter("{x:g}")
        delay_plot.set(xlabel="delay [s], and its median", ylim=(len(KINDS) - 0.5, -0.5))
    return figure
