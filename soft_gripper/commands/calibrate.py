"""soft-gripper calibrate: recordings of free bending -> gains, offsets and a bend ratio for each finger."""

import argparse
from dataclasses import asdict

from soft_gripper.files.output import check_file, keep_inputs
from soft_gripper.hardware.calibration import calibrate_recordings
from soft_gripper.scenario.calibration_file import save_calibration


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    keep_inputs(options.recording, [options.out])
    check_file(options.out)
    calibration = calibrate_recordings(options.recording)
    save_calibration(calibration, options.out)
    for name, finger in calibration.fingers.items():
        print(f"{name}: bends {finger.bend_ratio:.4f} times as far as nominal; residual {finger.residual:.2g}")
        print("  gains  ", *(f"{gain:8.4f}" for gain in finger.gains))
        print("  offsets", *(f"{offset:8.4f}" for offset in finger.offsets))
    print(f"assumed: {calibration.assumed}")
    options.console.document["fingers"] = {name: asdict(finger) for name, finger in calibration.fingers.items()}
    options.console.wrote(options.out)
