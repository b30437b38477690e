"""soft-gripper identify: hardware recordings -> a finger file with fitted parameters, and held-out predictions."""

import argparse
import sys
from pathlib import Path

from soft_gripper.commands.tables import print_defects, print_identified
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import check_file, keep_inputs
from soft_gripper.hardware.identification.identified_finger import (
    identify,
    identify_figure,
    read_finger,
    with_finger,
    write_finger,
)
from soft_gripper.hardware.identification.simulated_motion import MeasuredMotion, measured_motion
from soft_gripper.hardware.recordings import find_recordings, recording_paths
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    opened = open_executor(options.jobs, options.scheduler)
    file, out = model_path(options.finger), options.out
    finger = read_finger(file)
    fitted = _motions(options.file, options)
    tested = _motions(options.test, options) if options.test else []
    recordings = recording_paths([*options.file, *options.test], options.described_as, options.data)
    keep_inputs([file, *recordings], _outputs(out))
    check_file(out)
    with opened as executor:
        found = identify(finger, options.free, fitted, tested, executor, options.starts, options.seed, _report)
    print(file=sys.stderr)
    text = with_finger(file, found.model.finger)
    print_identified(found)
    save_figure(identify_figure(found), out.with_suffix(""))
    write_csv(out.with_suffix(".csv"), found.scores)
    write_finger(out, text)
    options.console.table("scores", found.scores)
    options.console.wrote(*_outputs(out))


def _outputs(out: Path) -> list[Path]:
    return [out.with_suffix(suffix) for suffix in (".urdf", ".csv", ".png", ".svg")]


def _motions(files: list[str], options: argparse.Namespace) -> list[MeasuredMotion]:
    recordings = find_recordings(files, options.described_as, options.data)
    print_defects(recordings)
    return [measured_motion(recording) for recording in recordings]


def _report(error: float) -> None:
    print(
        f"\rfitting: marker error {100 * error:.2f} % of the largest displacement ",
        end="",
        file=sys.stderr,
        flush=True,
    )
