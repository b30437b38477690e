"""Compares every shipped scenario in MuJoCo and in Drake: resting tips, forces of the fingers, and the end.

Writes docs/extras/mujoco_engine/agreement.csv, each row as soon as it is known, and puts the table into the
page beside it. Rows of other scenarios are kept. MuJoCo has contact at points, so it is also compared with Drake
with `contact: points`: differences that shrink there are due to the model of contact, not to the engine. Tips and
forces are compared at the end of each step of pressure or set point, and of a task at the end of the first phase that
holds the object; forces are means over the last half second before, and differences of smaller forces than 0.5 N are
shares of 0.5 N. A difference of the whole force, but not of the normal force, is friction.

`--boxes N` draws N boxes of random mass, friction and position for `box_grasp`, prints how many end alike and how
the others differ, and repeats the first heavy one in Drake with shorter steps. It writes boxes.csv and creep.csv
there. Coulomb friction at rest does not creep: the sinking of a box that friction could carry is the solver's error.
"""

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import Run, run_many
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, shortened
from soft_gripper.extras.sweeps.axes import Range, sweep_points
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.measured_runs import run_and_measure
from soft_gripper.extras.sweeps.sweep import run_sweep
from soft_gripper.files.row_table import print_rows, read_csv, write_csv
from soft_gripper.runs.scores.grasp import SLIDES, SUPPORTED, WINDOW, last
from soft_gripper.runs.scores.recorded_grasps import recorded_grasps
from soft_gripper.runs.scores.recorded_object import RecordedObject
from soft_gripper.runs.scores.steps import outcome
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import DRAKE
from soft_gripper.scenario.shipped import scenario_names
from studies import ROOT
from studies.page_table import write_table

TABLE, BOXES, CREEP = (
    ROOT / "docs/extras/mujoco_engine" / name for name in ("agreement.csv", "boxes.csv", "creep.csv")
)
PAGE = ROOT / "studies/engines/README.md"
HEADING = (
    "| scenario | tips [mm] | at points | force [%] | at points | normal force [%] | in Drake | in MuJoCo | step |",
    "|---|---:|---:|---:|---:|---:|---|---|---:|",
)
PAGE_SCENARIOS = 4  # scenarios on the page; the table has all
CREEP_HEADING = (
    "| simulator | step [ms] | `stiction_tolerance` [m/s] | end | lifted [mm] | sinks in the last second [mm] |",
    "|---|---:|---:|---|---:|---:|",
)
MEANED = 50  # samples before the end of a step
MIN_FORCE = 0.5  # N; differences of smaller forces are shares of it
BOX_GRASP, BOX, SINKING_TIME = "box_grasp", "box", 1.0  # s, over which a box sinks
MIN_CREEP_MASS = 0.13  # kg, of a box that shows creep
DRAWN_RANGES = {"mass": (0.05, 0.15), "friction": (0.5, 1.0), "X_PC.translation.0": (-0.004, 0.004)}  # kg, 1, m
REFINEMENTS: tuple[dict[str, Any], ...] = (
    {},
    {"plant_config.stiction_tolerance": 1e-6},
    *({"plant_config.time_step": step} for step in (0.005, 0.002, 0.001)),
    {"engine": "mujoco"},
)
CRITERION = (
    f"Held: in the last {WINDOW:g} s the fingers carry {1 - SUPPORTED:.0%} of the weight or more, or {SUPPORTED:.0%}"
    f" with friction for all of it, and the box slides on them by {1e3 * SLIDES:g} mm/s or less; resting: they do not."
)


@dataclass(frozen=True)
class EngineAgreement:
    """Agreement of a scenario in MuJoCo with Drake; worst of all fingers and steps."""

    scenario: str
    tips_mm: Annotated[float, ".2f"]
    force_percent: Annotated[float, ".1f"]
    normal_force_percent: Annotated[float, ".1f"]
    tips_mm_with_points: Annotated[float, ".2f"]
    force_percent_with_points: Annotated[float, ".1f"]
    normal_force_percent_with_points: Annotated[float, ".1f"]
    in_drake: str
    in_mujoco: str
    step: str


def compared_samples(run: Run) -> list[int]:
    """Indices of the compared samples."""
    scenario, task, samples = run.station.scenario, run.station.task, run.recording["time"].values
    if task is not None:
        holding = [number for number, phase in enumerate(task.phases) if phase.holds][:1]
        holding_samples = np.flatnonzero(np.isin(run.recording["task.phase"].values, holding))
        return [int(holding_samples[-1]) if len(holding_samples) else len(samples) - 1]
    times = scenario.step_duration * np.arange(1, scenario.steps + 1)
    return [int(np.searchsorted(samples, time + 1e-9)) - 1 for time in times]


def resting_tips(run: Run) -> Array:
    """Tips at the ends of K steps, (F, K, 3) m."""
    rows, fingers = compared_samples(run), run.station.fingers
    return np.array([run.recording[f"{finger.name}.true_tip_position"].values[rows] for finger in fingers])


def resting_forces(run: Run, signal: str) -> Array:
    """A signal of forces at the ends of K steps, (F, K) N."""
    forces = [run.recording[f"{finger.name}.{signal}"].values.ravel() for finger in run.station.fingers]
    return np.array(
        [[force[max(0, row - MEANED) : row + 1].mean() for row in compared_samples(run)] for force in forces]
    )


def ending(run: Run) -> str:
    """End of a run, in words."""
    grasps = [grasp.grasp for grasp in recorded_grasps(run.station, run.recording)[0]]
    return ", ".join([*grasps, *([] if run.station.task is None else [outcome(run.recording).words])]) or "-"


def run_changed(name: str, **changes: str) -> Run:
    """Runs a shipped scenario with changes."""
    (run,) = run_many([changed_scenario(name, changes)])
    if isinstance(run, Exception):
        raise run
    return run


def agreement(name: str) -> EngineAgreement:
    """Compares a shipped scenario in both engines."""
    mujoco, drake = run_changed(name, engine="mujoco"), run_changed(name, engine=DRAKE)
    with_points = run_changed(name, engine=DRAKE, contact="points")
    step = str(mujoco.recording.data.attrs["engine_step"]).partition(";")[0]
    return EngineAgreement(
        name, *compare_runs(mujoco, drake), *compare_runs(mujoco, with_points), ending(drake), ending(mujoco), step
    )


def compare_runs(mujoco: Run, drake: Run) -> tuple[float, float, float]:
    """Differences of tips, mm, and of forces and normal forces, percent of Drake's."""
    shift = float(np.linalg.norm(resting_tips(mujoco) - resting_tips(drake), axis=-1).max())
    percentages = []
    for signal in ("true_contact_total", "normal_force"):
        forces, drake_forces = resting_forces(mujoco, signal), resting_forces(drake, signal)
        percentages.append(float((np.abs(forces - drake_forces) / np.maximum(drake_forces, MIN_FORCE)).max()))
    return 1e3 * shift, 100 * percentages[0], 100 * percentages[1]


@dataclass(frozen=True)
class Box:
    """A box and its end in both engines; its weight over the available friction is that in Drake."""

    mass_kg: Annotated[float, ".4f"]
    friction: Annotated[float, ".3f"]
    off_middle_mm: Annotated[float, ".2f"]
    in_drake: str
    in_mujoco: str
    weight_over_friction: Annotated[float, ".3f"]


@dataclass(frozen=True)
class Creep:
    """Lift of a box at the end, and its sinking in the last second, at constant pressure."""

    engine: str
    step_ms: Annotated[float, "g"]
    stiction_tolerance: Annotated[float, "g"]
    end: str
    lifted_mm: Annotated[float, ".2f"]
    sinking_in_1_s_mm: Annotated[float, ".3f"]


@dataclass(frozen=True)
class EndCount:
    """Number of boxes with the same ends, and their largest weight over friction."""

    in_drake: str
    in_mujoco: str
    boxes: int
    largest_weight_over_friction: Annotated[float, ".2f"]


def weight_over_friction(station: Station, recording: Recording) -> float:
    """Weight of the box over the friction of all fingers together at the end; above 1 it slips by Coulomb's law."""
    signals = RecordedObject(station, recording, BOX).signals
    return signals.weight / float(signals.normal[last(signals.time)].mean(axis=0) @ signals.coefficients)


def lifted_mm(station: Station, recording: Recording) -> float:
    """Height of the box at the end above where it settles first, mm."""
    heights = recording.values(f"{BOX}.pose")[:, 6]
    return 1e3 * float(heights[-1] - heights[round(SINKING_TIME / station.scenario.sensor.period)])


def sinking_mm(station: Station, recording: Recording) -> float:
    """Sinking of the box in the last second, mm."""
    heights = recording.values(f"{BOX}.pose")[:, 6]
    return 1e3 * float(heights[-1 - round(SINKING_TIME / station.scenario.sensor.period)] - heights[-1])


MEASURES = [
    f"{Path(__file__).resolve()}:{measure.__name__}" for measure in (weight_over_friction, lifted_mm, sinking_mm)
]


def draw_boxes(number: int) -> list[Box]:
    """Draws boxes as `soft-gripper sweep --sample` does, and simulates them."""
    axes = [Range(f"models.{BOX}.{key}", *limits) for key, limits in DRAWN_RANGES.items()]
    points = sweep_points(axes, "latin", number)
    rows: dict[str, list[dict[str, str]]] = {}
    with TemporaryDirectory() as folder, open_executor() as executor:
        for engine in ("mujoco", DRAKE):
            out, engine_change = Path(folder) / engine, {"engine": engine}
            rows[engine] = run_sweep(BOX_GRASP, points, out, executor, fixed=engine_change, own=MEASURES[:1])
    return [
        Box(mass, friction, 1e3 * x, drake["grasp"], mujoco["grasp"], float(drake[weight_over_friction.__name__]))
        for (mass, friction, x), drake, mujoco in zip(
            (map(float, point.values()) for point in points), rows[DRAKE], rows["mujoco"], strict=True
        )
    ]


def count_ends(boxes: Sequence[Box]) -> list[EndCount]:
    """Counts the ends of boxes, the most frequent first."""
    counts = Counter((box.in_drake, box.in_mujoco) for box in boxes)
    return [
        EndCount(*endings, count, max(b.weight_over_friction for b in boxes if (b.in_drake, b.in_mujoco) == endings))
        for endings, count in counts.most_common()
    ]


def creep(box: Box, changes: Mapping[str, Any]) -> Creep:
    """Simulates the creep of a box in `box_grasp` with changes."""
    place = dict(zip(DRAWN_RANGES, (box.mass_kg, box.friction, 1e-3 * box.off_middle_mm), strict=True))
    changes = {**{f"models.{BOX}.{key}": value for key, value in place.items()}, **changes}
    measures = run_and_measure(BOX_GRASP, changes, MEASURES)
    plant = changed_scenario(BOX_GRASP, changes).plant_config
    engine = str(changes.get("engine", DRAKE))
    step, tolerance = (1e3 * plant.time_step, plant.stiction_tolerance) if engine == DRAKE else (np.nan, np.nan)
    numbers = (measures[measure.__name__] for measure in (lifted_mm, sinking_mm))
    return Creep(engine, step, tolerance, measures["grasp"], *numbers)


def compare_boxes(number: int) -> None:
    """Writes and prints the ends of random boxes, and the creep of a heavy one."""
    boxes = draw_boxes(number)
    write_csv(BOXES, boxes)
    equal = sum(box.in_drake == box.in_mujoco for box in boxes)
    print_rows(count_ends(boxes), f"{equal} of {number} boxes end alike. {CRITERION}")
    sinking = next((box for box in boxes if box.mass_kg > MIN_CREEP_MASS), None)
    if sinking is not None:
        rows = [creep(sinking, changes) for changes in REFINEMENTS]
        write_csv(CREEP, rows)
        write_table(PAGE, creep_table(rows))
        print_rows(rows, f"A box of {1e3 * sinking.mass_kg:.0f} g and friction {sinking.friction:.2f}")


def page_table(rows: Sequence[EngineAgreement]) -> list[str]:
    """Lines of the page's table: the scenarios whose forces differ most."""
    lines = [
        f"| `{row.scenario}` | {row.tips_mm:.2f} | {row.tips_mm_with_points:.2f} | {row.force_percent:.1f}"
        f" | {row.force_percent_with_points:.1f} | {row.normal_force_percent:.1f}"
        f" | {row.in_drake} | {row.in_mujoco} | {row.step} |"
        for row in sorted(rows, key=lambda row: -row.force_percent)[:PAGE_SCENARIOS]
    ]
    return [*HEADING, *lines]


def creep_table(rows: Sequence[Creep]) -> list[str]:
    """Lines of the table of a box that sinks; only Drake has a stiction tolerance."""
    lines = [
        f"| {f'Drake | {row.step_ms:g} | {row.stiction_tolerance:g}' if row.engine == DRAKE else 'MuJoCo | | '}"
        f" | {row.end} | {row.lifted_mm:.2f} | {row.sinking_in_1_s_mm:.3f} |"
        for row in rows
    ]
    return [*CREEP_HEADING, *lines]


def run(options: argparse.Namespace) -> None:
    """Writes the table of scenarios, or compares boxes."""
    if options.boxes is not None:
        compare_boxes(options.boxes)
        return
    rows = {row.scenario: row for row in read_csv(TABLE, EngineAgreement)} if TABLE.is_file() else {}
    for name in options.scenarios or scenario_names():
        try:
            rows[name] = agreement(name)
        except InputError as error:
            print(f"{name}: {shortened(str(error), 200)}")
            continue
        print(rows[name], flush=True)
        write_csv(TABLE, [rows[scenario] for scenario in sorted(rows)])
    write_table(PAGE, page_table([rows[scenario] for scenario in sorted(rows)]))
