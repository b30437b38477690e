"""soft-gripper calibrate: recordings of free bending -> gains, offsets and a bend ratio for every finger."""

import argparse

from soft_gripper.commands.terminal.paths import path
from soft_gripper.commands.terminal.subparsers import Subparsers
from soft_gripper.diagrams.loading.calibration_file import save_calibration
from soft_gripper.evaluation.calibrate_recordings import calibrate_recordings
from soft_gripper.files import check_file


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = subparsers.add_parser("calibrate", help="calibrate sensors and fingers from recordings of free bending")
    parser.add_argument("recording", nargs="+", type=path, help="a recording.nc that `soft-gripper run` wrote")
    parser.add_argument("--out", metavar="FILE", type=path, required=True, help="YAML file for believed.calibration")
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    check_file(options.out)
    calibration = calibrate_recordings(options.recording)
    save_calibration(calibration, options.out)
    for name, finger in calibration.fingers.items():
        print(f"{name}: bends {finger.bend_ratio:.4f} times as far as believed; residual {finger.residual:.2g}")
        print("  gains  ", *(f"{gain:8.4f}" for gain in finger.gains))
        print("  offsets", *(f"{offset:8.4f}" for offset in finger.offsets))
    print(f"assumed: {calibration.assumed}")
