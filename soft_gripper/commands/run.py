"""soft-gripper run: runs one scenario headless or in Meshcat, and can save an animation or a video."""

import argparse
import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext
from itertools import chain, count
from pathlib import Path
from typing import Any

from pydrake.geometry import Meshcat

from soft_gripper.commands.chosen_station import chosen_station
from soft_gripper.commands.console import Console
from soft_gripper.commands.printing import (
    changes_line,
    print_grasps,
    print_phases,
    print_poses,
    print_slips,
    print_truth,
)
from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.contact_forces import forces_text
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import check_closed, run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file, check_file, lock_folder
from soft_gripper.files.row_table import print_rows
from soft_gripper.files.text import read_text
from soft_gripper.registry import registered
from soft_gripper.runs.scores.contact_forces import (
    DRAWN_FORCES,
    band_widths,
    contact_rows,
    drawn_forces,
    end_of_hold,
    estimator_of_forces,
    has_forces,
)
from soft_gripper.runs.scores.external_torques import recorded_force_table
from soft_gripper.runs.scores.grasp import DROPPED, NEVER_TOUCHED, SLIPPING
from soft_gripper.runs.scores.narrower_bands import WIDE, narrower_text
from soft_gripper.runs.scores.poses import recorded_pose_table
from soft_gripper.runs.scores.recorded_grasps import (
    ObjectGrasp,
    ObjectGrip,
    note_welded_object,
    recorded_grasps,
    touched_instead,
)
from soft_gripper.runs.scores.recorded_slips import recorded_slips
from soft_gripper.runs.scores.recorded_task import TaskRun, judged
from soft_gripper.runs.scores.steps import outcome, phase_table, step_table
from soft_gripper.runs.success import success_criteria, success_rows
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.scenario_file import dump_scenario, files_read
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.sensor_presets import SENSORS, uncertainty
from soft_gripper.sensors.observability import observability


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    success_criteria(options.chosen_scenario)  # a wrong one is reported before anything is built
    name, station = Path(options.scenario).stem, chosen_station(options)
    scenario = station.scenario
    check_closed(station)
    out = run_folder(options.out, name, scenario)
    input_files = files_read(options.scenario, scenario)
    _check_files(options, input_files)
    lock_folder(out, [] if fits(out, scenario) else ["scenario.yaml"], input_files)
    meshcat = None
    if options.meshcat or options.html:
        from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat

        meshcat = hidden_meshcat()
        station = make_private_station(scenario, meshcat)
    with registered("VIEWERS")["meshcat"](meshcat, options.host) if options.meshcat else nullcontext():
        recording = _run_and_write(options, name, station, meshcat, out)
    return 0 if station.task is None or outcome(recording) == Outcome.DONE else 1


def _run_and_write(
    options: argparse.Namespace, name: str, station: Station, meshcat: Meshcat | None, out: Path
) -> Recording:
    """Runs a station and writes everything requested."""
    console, scenario = options.console, station.scenario
    for line in observability_lines(station):
        print(line, file=sys.stderr)
    with console.progress(name, scenario.duration) as progress:
        recording = run_station(station, meshcat, progress)
    reports = (report(station, recording) for report in registered("REPORTS").values())
    for line in (*chain.from_iterable(reports), *drift_lines(station, recording)):
        print(line)
    paths = [out / file for file in _write(out, name, station, recording, console)]
    if options.mcap is not None:
        recording.save(options.mcap)
        paths.append(options.mcap)
    if meshcat is not None and options.html is not None:
        from soft_gripper.diagrams.view.meshcat_view import write_animation

        write_animation(meshcat, options.html)
        paths.append(options.html)
    if options.video is not None:
        from soft_gripper.pictures.video import write_video

        with console.progress("film", float(recording.data["time"][-1])) as progress:
            write_video(options.video, scenario, recording, progress)
        paths.append(options.video)
    console.wrote(*paths)
    return recording


def drift_lines(station: Station, recording: Recording) -> list[str]:
    """Final drift since calibration of each finger that `recursive` estimates."""
    return [
        changes_line(finger.name, lambda name: recording[name].values[-1])
        for finger in station.fingers
        if f"{finger.name}.bend_change" in recording.data
    ]


def observability_lines(station: Station) -> list[str]:
    """Lines on the deformations that the sensors of fingers in space observe, and on the others."""
    scenario = station.scenario
    names_by_observability: dict[tuple[str, ...], list[str]] = {}
    for finger in station.fingers:
        if len(finger.finger.yields) > 1 and station.parts.sensor in SENSORS:
            noise = float(uncertainty(scenario.estimator, scenario.sensor).any_reading())
            layout = read_nominal_model(scenario.nominal).layout(finger.finger, scenario.sensor)
            names_by_observability.setdefault(tuple(map(str, observability(layout, noise))), []).append(finger.name)
    return [
        f"note: what the sensors of {', '.join(names)} observe of each section: {', '.join(is_observed)}"
        for is_observed, names in names_by_observability.items()
    ]


def run_folder(folder_option: Path | None, name: str, scenario: Scenario) -> Path:
    """The folder for the results of a scenario.

    By default, results/NAME, or the first of results/NAME-2, -3 ... that is free or holds this very scenario. In a
    folder that was requested, other results are replaced, with a note.
    """
    if folder_option is not None:
        if not fits(folder_option, scenario):
            print(f"note: {folder_option} held results of another scenario or of other settings", file=sys.stderr)
        return folder_option
    base = Path("results") / name
    folder = next(f for f in (base if i == 1 else base.with_name(f"{name}-{i}") for i in count(1)) if fits(f, scenario))
    if folder != base:
        print(f"note: {base} holds a run with other settings; the results go to {folder}", file=sys.stderr)
    return folder


def fits(folder: Path, scenario: Scenario) -> bool:
    """Whether a folder holds no run, or a run of exactly this scenario."""
    file = folder / "scenario.yaml"
    if not os.path.isfile(file):
        return True
    try:
        text = read_text(file)
    except InputError:
        return False
    return text == dump_scenario(scenario, folder)


def _check_files(options: argparse.Namespace, input_files: Sequence[str]) -> None:
    """Checks, before the run starts, that all requested files can be written and that no input file is overwritten."""
    if options.video is not None:
        from soft_gripper.pictures.video import check_video

        check_video(options.video)
    for file in (options.video, options.html, options.mcap):
        if file is not None:
            check_file(file, input_files)


def _write(out: Path, name: str, station: Station, recording: Recording, console: Console) -> list[str]:
    """Writes the recording and the tables that suit the scenario, and prints the tables; returns the files."""
    recording.save(out / "recording.nc")
    with atomic_file(out / "scenario.yaml") as partial:
        partial.write_text(dump_scenario(station.scenario, out), encoding="utf-8")
    grasps, grips = recorded_grasps(station, recording)
    files = [
        *_write_scores(out, name, station, recording, grasps, console),
        *_write_forces(out, station, recording, console),
        *_write_grasps(out, station, recording, grasps, grips, console),
        *_write_success(out, station, recording, console),
    ]
    return ["recording.nc", "scenario.yaml", *files]


def _write_forces(out: Path, station: Station, recording: Recording, console: Console) -> list[str]:
    """Writes the contact forces at the end of each step or phase, and prints those of the hold, if there is contact."""
    if not has_forces(station, recording):
        return []
    rows = contact_rows(station, recording)
    console.table("contact_forces", rows, out / "contact_forces.csv")
    end = end_of_hold(rows, station, recording)
    end_rows = [row for row in rows if row.time_s == end]
    print(f"\n{forces_text(end_rows, estimator_of_forces(station, recording))}")
    for row in end_rows:
        if row.most_n - row.least_n > WIDE * row.transverse_n:
            print(narrower_text(row.finger, band_widths(station, recording, row)), end="")
    return ["contact_forces.csv"]


def _write_grasps(
    out: Path,
    station: Station,
    recording: Recording,
    grasps: Sequence[ObjectGrasp],
    grips: Sequence[ObjectGrip],
    console: Console,
) -> list[str]:
    """Writes and prints how the objects are held, and why they slip, if there are any."""
    if not grasps:
        note_welded_object(station, recording)
        return []
    slips = recorded_slips(station, recording)
    tables: dict[str, Sequence[Any]] = {"grasps": grasps, "grips": grips, "slips": slips}
    for table, rows in tables.items():
        console.table(table, rows, out / f"{table}.csv")
    print_grasps(grasps, grips, touched_instead(station, recording))
    print_slips(slips)
    return [f"{table}.csv" for table in tables]


def _write_success(out: Path, station: Station, recording: Recording, console: Console) -> list[str]:
    """Writes and prints whether the run meets each criterion of success, if the whole ground truth is there."""
    rows = success_rows(station, recording) if station.scenario.record.truth == "all" else []
    if not rows:
        return []
    console.table("success", rows, out / "success.csv")
    print(f"\nCriteria of success: {sum(row.met for row in rows)} of {len(rows)} met")
    for row in rows:
        print(f"  {'yes' if row.met else 'NO '}  {row.criterion}{row.measured and f' ({row.measured})'}")
    return ["success.csv"]


def _not_held(station: Station, grasps: Sequence[ObjectGrasp]) -> list[str]:
    """Objects that are not held in truth, in words; an untouched object counts only if the task handles it."""
    task = station.scenario.task
    return [
        f"{grasp.object} {grasp.grasp}"
        for grasp in grasps
        if grasp.grasp in (DROPPED, SLIPPING)
        or (grasp.grasp == NEVER_TOUCHED and task is not None and grasp.object == task.object)
    ]


def _write_scores(
    out: Path, name: str, station: Station, recording: Recording, grasps: Sequence[ObjectGrasp], console: Console
) -> list[str]:
    """Writes and prints the table that suits the scenario; returns the files."""
    if station.task is not None:
        from soft_gripper.pictures.phases import phases_figure

        phases = phase_table(station, recording)
        assert station.scenario.task is not None
        is_true = station.scenario.record.truth == "all"
        slips = TaskRun(station, recording).slips if is_true and station.scenario.task.object else None
        forces = drawn_forces(station, recording)
        with atomic_file(out / "phases.png") as partial:
            figure = phases_figure(station.scenario, recording, station.task.phases, slips, forces)
            figure.savefig(partial, format="png")
        files = ["phases.csv", "phases.png"]
        if forces is not None:
            console.table(DRAWN_FORCES, forces.rows(), out / f"{DRAWN_FORCES}.csv")
            files.append(f"{DRAWN_FORCES}.csv")
        print_phases(phases, outcome(recording), station.scenario.task, _not_held(station, grasps))
        console.table("phases", phases, out / "phases.csv")
        console.document["outcome"] = outcome(recording).words
        looked_for = station.scenario.estimator.contact_threshold is not None
        if is_true and looked_for and any(phase.holds for phase in station.task.phases):
            truth = judged(station, recording)
            print_truth(truth)
            console.table("truth", [truth])
        return files
    if station.scenario.record.truth == "none":
        print("There is no ground truth to compare with (record.truth: none).")
        return []
    if station.scenario.control.set_points is not None:
        steps = step_table(station, recording)
        console.table("steps", steps, out / "steps.csv")
        print_rows(steps)
        return ["steps.csv"]
    poses = recorded_pose_table(name, station, recording)
    console.table("poses", poses, out / "metrics.csv")
    console.table("forces", recorded_force_table(name, station, recording), out / "forces.csv")
    print_poses(poses)
    return ["metrics.csv", "forces.csv"]
