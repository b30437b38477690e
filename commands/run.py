"""soft-gripper run: one scenario, headless, in Meshcat, or as a replay to keep."""

import argparse
import logging
from pathlib import Path

from pydrake.geometry import Meshcat

from soft_gripper.commands.options import Subparsers, add_scenario_options, chosen_station
from soft_gripper.commands.progress import progress_bar
from soft_gripper.commands.tables import print_phases, print_poses, print_steps, print_truth
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.scenario_file import dump_scenario
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import Station, make_station
from soft_gripper.diagrams.view.replay import write_replay
from soft_gripper.evaluation.csv_table import write_csv
from soft_gripper.evaluation.phase_table import outcome, phase_table
from soft_gripper.evaluation.pose_table import pose_table
from soft_gripper.evaluation.step_table import step_table
from soft_gripper.evaluation.trial import trial_row
from soft_gripper.files import whole_file, writable_folder
from soft_gripper.pictures.phases_figure import phases_figure
from soft_gripper.pictures.video import check_video, write_video
from soft_gripper.task_phases import Outcome


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = subparsers.add_parser("run", help="run a scenario and record every signal")
    add_scenario_options(parser)
    parser.add_argument("--out", metavar="DIR", type=Path, help="default: results/SCENARIO")
    parser.add_argument("--meshcat", action="store_true", help="show the run in a browser and wait at its end")
    parser.add_argument("--html", metavar="FILE", type=Path, help="write a 3-D replay that opens offline")
    parser.add_argument("--video", metavar="FILE", type=Path, help="write a film: .mp4, .gif, .webp or .png")
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> int:
    name, station = Path(options.scenario).stem, chosen_station(options)
    scenario = station.scenario
    out = _output_folder(options, name)
    if not options.meshcat:
        logging.getLogger("drake").setLevel(logging.WARNING)  # no address to open
    meshcat = Meshcat() if options.meshcat or options.html else None
    if meshcat is not None:
        station = make_station(scenario, meshcat)
    with progress_bar(name, scenario.duration) as progress:
        recording = run_station(station, meshcat, progress)
    written = _write(out, name, station, recording)
    if meshcat is not None and options.html is not None:
        write_replay(meshcat, options.html)
        written.append(str(options.html))
    if options.video is not None:
        with progress_bar("film", float(recording.data["time"][-1])) as progress:
            write_video(options.video, scenario, recording, progress)
        written.append(str(options.video))
    print(f"\nWritten to {out}: {', '.join(written)}")
    if options.meshcat:
        input("The replay is in Meshcat. Press Enter to end. ")
    return 0 if station.task is None or outcome(recording) == Outcome.DONE else 1


def _output_folder(options: argparse.Namespace, name: str) -> Path:
    """The folder for the results; all that is to be written can be, or nothing is begun."""
    if options.video is not None:
        check_video(options.video)
    for file in (options.video, options.html):
        if file is not None:
            writable_folder(file.parent)
    return writable_folder(options.out or Path("results") / name)


def _write(out: Path, name: str, station: Station, recording: Recording) -> list[str]:
    """Writes what was recorded, with the table that fits the scenario, and prints the table; returns the files."""
    files = ["recording.nc", "scenario.yaml"]
    recording.save(out / "recording.nc")
    with whole_file(out / "scenario.yaml") as partial:
        partial.write_text(dump_scenario(station.scenario), encoding="utf-8")
    if station.task is not None:
        phases = phase_table(station, recording)
        write_csv(out / "phases.csv", phases)
        with whole_file(out / "phases.png") as partial:
            phases_figure(station.scenario, recording, station.task.phases).savefig(partial, format="png")
        print_phases(phases, outcome(recording), station.scenario.task)
        if station.scenario.sensor.contact_threshold > 0 and any(phase.holds for phase in station.task.phases):
            print_truth(trial_row(name, 0, station, recording))
        return [*files, "phases.csv", "phases.png"]
    if station.scenario.control.set_points:
        steps = step_table(station, recording)
        write_csv(out / "steps.csv", steps)
        print_steps(steps)
        return [*files, "steps.csv"]
    poses = pose_table(name, station, recording, [station.scenario.sensor.sections])
    write_csv(out / "metrics.csv", poses)
    print_poses(poses)
    return [*files, "metrics.csv"]
