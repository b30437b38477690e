"""The evaluation: runs scenarios in parallel, then makes the tables, figures and claims of all."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.paper.bars import estimator_claims
from soft_gripper.extras.paper.claims import claims
from soft_gripper.extras.paper.contact_table import ContactRow, touched_finger_rows
from soft_gripper.extras.paper.differences import differences, held_tip_errors
from soft_gripper.extras.paper.figures import (
    contact_figure,
    contact_force_figure,
    force_figure,
    free_bending_figure,
)
from soft_gripper.extras.paper.forces import ContactForceRow
from soft_gripper.extras.paper.page import Evaluation, difference_figure, estimators_figure, write_report
from soft_gripper.extras.paper.pose_rows import estimator_rows
from soft_gripper.extras.paper.scenario_run import (
    CONTACT,
    FREE,
    SCENARIOS,
    evaluated_scenario,
    is_finished,
    run_scenario,
)
from soft_gripper.extras.paper.scenes_figure import scenes_figure
from soft_gripper.extras.sweeps.study import run_study
from soft_gripper.files.output import atomic_folder, read_folder, write_folder
from soft_gripper.files.row_table import Row, read_csv, write_csv
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.phases import phases_figure
from soft_gripper.pictures.section_figure import section_figure
from soft_gripper.pictures.shape_figure import shape_figure
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.scores.contact_forces import DRAWN_FORCES, drawn_forces
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.recorded_task import TaskRun
from soft_gripper.runs.scores.steps import PhaseRow, outcome, phase_table
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import sensor_layout

TASK = "pick_and_place_box"
RUNS = (*SCENARIOS, TASK)
CAPTIONS = {
    "fig8_scenarios": "The scenarios at the start and at their largest pressure (the paper's Fig. 8), the fingers"
    " coloured by the external torque at their joints.",
    "finger_section": "The section of the finger at base and tip, to scale: walls, chamber, layer, neutral axis.",
    "fig4_shape": "A finger obstructed inside (Fig. 4): the simulation, the estimated arcs, the estimate.",
    "fig5_free_bending": "Free bending (Fig. 5): errors of the estimated pose against the bend angle, both panels on"
    " one scale.",
    "difference": "Why the paper's fingertip error in free bending hardly depends on the number of sensors: with joints"
    " where the segments begin, half of the first joint's angle is turned before the sensors, and none measures it.",
    "fig6_pose_error": "Contact (Fig. 6): mean pose error against the pressure, all panels on one logarithmic scale.",
    "fig7_fingertip_error": "Contact (Fig. 7): fingertip error against the pressure, all panels on one logarithmic"
    " scale.",
    "estimators": "Mean pose error of the estimators with one to four sensors per side, on a logarithmic scale. Dashed:"
    " what the paper reports of arcs with four. Errors below 1 µm are drawn at 1 µm.",
    "force_estimate": "External torque along a finger at the last step, and its mean error against pressure.",
    "contact_force": "Normal force and contact location, estimated from strain and pressure only, with the"
    " true values.",
}
Advance = Callable[[float], Any]


def unfinished_runs(out: Path) -> list[str]:
    """Names in RUNS without a complete run in `out`."""
    return [name for name in RUNS if not is_finished(out / name, evaluated_scenario(name))]


def run_scenarios(names: Sequence[str], out: Path, executor: Executor, advance: Advance) -> None:
    """Runs scenarios and the task, each into its own folder below `out`.

    Args:
        executor: runs them.
        advance: called with the seconds of simulated time of every scenario that has ended.

    Raises:
        InputError, SimulationDivergedError, WorkerDiedError: if a scenario fails; the others are finished first.
    """
    scenarios = {name: evaluated_scenario(name) for name in names}
    longest_first = sorted(names, key=lambda name: -len(scenarios[name].models))
    jobs = {out / name: (name,) for name in longest_first}
    duration = {out / name: scenario.duration for name, scenario in scenarios.items()}
    run_study(executor, run_files, jobs, write_folder, ended=lambda folder: advance(duration[folder]))


def run_files(name: str) -> dict[str, bytes]:
    """Runs a scenario or the task; returns the written files by name."""
    with TemporaryDirectory(prefix="soft-gripper-") as temporary:
        folder = Path(temporary) / "run"
        (run_task if name == TASK else run_scenario)(name, folder)
        return read_folder(folder)


def run_task(name: str, folder: Path) -> None:
    """Writes scenario.yaml, recording.nc, phases.csv, phases.png and the forces into `folder`: all files or none.

    Args:
        name: of a scenario with a task.
        folder: appears when it is whole.
    """
    scenario = evaluated_scenario(name)
    station = make_private_station(scenario)
    recording = run_station(station)
    assert station.task is not None
    with atomic_folder(folder) as partial:
        recording.save(partial / "recording.nc")
        write_csv(partial / "phases.csv", phase_table(station, recording))
        slips = TaskRun(station, recording).slips
        forces = drawn_forces(station, recording)
        phases_figure(scenario, recording, station.task.phases, slips, forces).savefig(partial / "phases.png")
        if forces is not None:
            write_csv(partial / f"{DRAWN_FORCES}.csv", forces.rows())
        (partial / "scenario.yaml").write_text(dump_scenario(scenario), encoding="utf-8")


def summarize(out: Path) -> Evaluation:
    """Writes the tables, the figures and the report from the finished runs in `out`."""
    poses, forces = _gather(out, "metrics.csv", PoseRow), _gather(out, "forces.csv", ForceRow)
    contacts = _gather(out, "contact.csv", ContactRow)
    force_rows = touched_finger_rows(_gather(out, "contact_forces.csv", ContactForceRow), contacts)
    poses, forces = touched_finger_rows(poses, contacts), touched_finger_rows(forces, contacts)
    evaluation = _evaluate(out, poses, forces, contacts, force_rows)
    write_report(out, SCENARIOS, evaluation, CAPTIONS, out / TASK / "phases.png")
    return evaluation


def _gather(out: Path, file: str, kind: type[Row]) -> list[Row]:
    """Joins the rows of a table of all scenarios, and writes them into one file."""
    rows = [row for name in SCENARIOS for row in read_csv(out / name / file, kind)]
    write_csv(out / file, rows)
    return rows


def _evaluate(
    out: Path,
    poses: list[PoseRow],
    forces: list[ForceRow],
    contacts: list[ContactRow],
    force_rows: list[ContactForceRow],
) -> Evaluation:
    """Derives the results from the tables and writes the figures; those of the paper show `arcs`."""
    runs = {name: (evaluated_scenario(name), Recording.load(out / name / "recording.nc")) for name in SCENARIOS}
    bend, errors = held_tip_errors(*runs[FREE], _finger(*runs[FREE]))
    arcs, torques = estimator_rows(poses, "arcs"), estimator_rows(forces, "arcs")
    figures = {
        **_scenario_figures(runs, arcs, torques),
        "estimators": estimators_figure(poses, SCENARIOS),
        "contact_force": contact_force_figure(force_rows, CONTACT),
        "difference": difference_figure(bend, errors),
    }
    for name, figure in figures.items():
        save_figure(figure, out / name)
    return Evaluation(
        poses,
        forces,
        claims(arcs, torques) + estimator_claims(poses),
        contacts,
        differences(arcs, FREE, CONTACT, errors),
        read_csv(out / TASK / "phases.csv", PhaseRow),
        outcome(Recording.load(out / TASK / "recording.nc")).words,
    )


def _scenario_figures(
    runs: dict[str, tuple[Scenario, Recording]], poses: list[PoseRow], forces: list[ForceRow]
) -> dict[str, Figure]:
    """The figures of the scenarios, by the names of `CAPTIONS`."""
    scenario, recording = runs["obstructed_inside"]
    layout = sensor_layout(_finger(scenario, recording), scenario.sensor)
    return {
        "finger_section": section_figure(layout.finger),
        "fig4_shape": shape_figure(layout, recording, scenario.duration),
        "fig5_free_bending": free_bending_figure([row for row in poses if row.scenario == FREE]),
        "fig6_pose_error": contact_figure(poses, CONTACT, "pose_error_mm"),
        "fig7_fingertip_error": contact_figure(poses, CONTACT, "tip_error_mm"),
        "fig8_scenarios": scenes_figure(runs),
        "force_estimate": force_figure(forces, CONTACT),
    }


def _finger(scenario: Scenario, recording: Recording) -> Finger:
    """The finger of a scenario with the largest contact force at the end; the first without contact."""
    fingers = make_private_station(scenario).fingers
    link_forces = [recording[f"{finger.name}.link_contact_force"].values[-1].sum() for finger in fingers]
    return fingers[int(np.argmax(link_forces))].finger
