"""soft-gripper identify: recordings of hardware -> a finger file with fitted parameters, and what they predict."""

import argparse
import sys
from pathlib import Path

from soft_gripper.commands.terminal.console import add_console_options
from soft_gripper.commands.terminal.options import (
    MOST_SEED,
    Subparsers,
    add_command,
    add_executor_options,
    chosen_executor,
    path,
    whole_number,
)
from soft_gripper.commands.terminal.tables import print_identified
from soft_gripper.errors import InputError
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import check_file, keep_inputs
from soft_gripper.hardware.identification.figure import identify_figure
from soft_gripper.hardware.identification.finger_file import read_finger, with_finger, write_finger
from soft_gripper.hardware.identification.identification import identify
from soft_gripper.hardware.identification.measured_motion import MeasuredMotion, measured_motion
from soft_gripper.hardware.recordings.find_recordings import find_recordings, recording_paths
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.model_files import model_path


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        "identify",
        "fit parameters of a finger to recordings of hardware",
        "swing.csv --as mine.yaml --finger mine.urdf --free youngs_modulus relaxation_time --out fitted.urdf",
        "a.csv b.csv --test c.csv --as mine.yaml --finger mine.urdf --free youngs_modulus --out fitted.urdf",
    )
    add_console_options(parser)
    parser.add_argument("file", nargs="+", help="a recording to fit to; looked for here, then below the data folder")
    parser.add_argument("--as", dest="described_as", metavar="NAME", help="description: a shipped one, or a YAML file")
    parser.add_argument("--test", nargs="+", default=[], metavar="FILE", help="recordings held out for testing")
    parser.add_argument("--finger", required=True, metavar="FILE", help="URDF with one finger: where the fit begins")
    parser.add_argument(
        "--free", nargs="+", required=True, metavar="KEY", help="what is fitted, such as youngs_modulus"
    )
    parser.add_argument("--out", required=True, metavar="FILE", type=path, help="URDF; a table and a figure beside it")
    parser.add_argument("--data", metavar="FOLDER", type=path, help="default: the environment's SOFT_GRIPPER_DATA")
    parser.add_argument("--starts", default="1", metavar="N", help="fits of which the best is taken; default: 1")
    parser.add_argument("--seed", default="0", metavar="N", help="of where the further fits begin")
    add_executor_options(parser)
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    starts = whole_number("identify", "--starts", options.starts, 1)
    seed = whole_number("identify", "--seed", options.seed, 0, MOST_SEED)
    opened = chosen_executor("identify", options)
    file, out = model_path(options.finger), options.out
    finger = read_finger(file)
    if out.suffix != ".urdf":
        raise InputError("identify", "--out", str(out), "name a .urdf; the table and the figure get its name")
    fitted = _motions(options.file, options)
    tested = _motions(options.test, options) if options.test else []
    recordings = recording_paths([*options.file, *options.test], options.described_as, options.data)
    keep_inputs([file, *recordings], _outputs(out))
    check_file(out)
    with opened as executor:
        found = identify(finger, options.free, fitted, tested, executor, starts, seed, _report)
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
    for recording in recordings:
        for gap in recording.gaps:
            print(f"note: {recording.name}: {gap}", file=sys.stderr)
    return [measured_motion(recording) for recording in recordings]


def _report(error: float) -> None:
    print(
        f"\rfitting: markers off by {100 * error:.2f} % of the largest displacement ",
        end="",
        file=sys.stderr,
        flush=True,
    )
