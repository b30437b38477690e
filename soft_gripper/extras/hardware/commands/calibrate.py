"""soft-gripper calibrate: recordings of free bending -> gains, offsets and a bend per pressure for each finger."""

import argparse
from dataclasses import asdict

from soft_gripper.extras.hardware.calibration import calibrate_recordings, save_calibration
from soft_gripper.extras.hardware.finger_logs import load_log
from soft_gripper.extras.hardware.free_bending import GAIN, SOUGHT
from soft_gripper.files.output import check_file
from soft_gripper.scenario.calibration_file import FingerCalibrationConfig

_UNDETERMINED_SHARE = 0.5  # of the prior standard deviation; a gain with a larger one counts as not determined


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    description_files = (options.scenario, options.bench, options.described_as)
    check_file(options.out, [*options.recording, *(file for file in description_files if file is not None)])
    log = load_log(options.scenario, options.bench, options.described_as, "calibrate")
    calibration = calibrate_recordings(options.recording, log, options.find)
    save_calibration(calibration, options.out)
    for name, finger in calibration.fingers.items():
        _print(name, finger)
    print(f"assumed: {calibration.assumed}")
    options.console.document["fingers"] = {name: asdict(finger) for name, finger in calibration.fingers.items()}
    options.console.wrote(options.out)


def _print(name: str, finger: FingerCalibrationConfig) -> None:
    ratio = f"{finger.bend_ratio:.4f} +- {finger.bend_ratio_std:.4f}"
    print(f"{name}: bends {ratio} times as far as nominal; residual {finger.residual:.2g}")
    rows = {
        "gains": (finger.gains, "{:9.4f}"),
        "  +-": (finger.gain_stds, "{:9.4f}"),
        "offsets": (finger.offsets, "{:9.5f}"),
        "  +- ": (finger.offset_stds, "{:9.5f}"),
        "drift [%/min]": ([6000 * drift for drift in finger.drifts], "{:9.3f}"),
    }
    for title, (values, number_format) in rows.items():
        print(f"  {title:<15}", *(number_format.format(value) for value in values), sep="")
    print(f"  hysteresis {100 * finger.hysteresis:.2f} % of the stroke")
    sought = {  # with --find
        "pressure offset": (finger.pressure_offset, finger.pressure_offset_std, " Pa"),
        "response curvature": (finger.response_curvature, finger.response_curvature_std, ""),
        "variation of the bend": (finger.bend_variation, finger.bend_variation_std, ""),
    }
    for name, (value, std, unit) in sought.items():
        if std > 0:
            print(f"  {name} {value:.4g} +- {std:.2g}{unit}")
            if std > _UNDETERMINED_SHARE * SOUGHT[name.partition(" ")[0]]:
                print(f"  note: the {name} is hardly known better than before: a measured tip would help")
    if finger.strength_std > 0:
        strength = f"{finger.strength:.3f} +- {finger.strength_std:.3f}"
        print(f"  measured forces: {strength} times nominal; friction of the presses {finger.friction:.2f}")
    unknown_sensors = [str(i) for i, std in enumerate(finger.gain_stds) if std > _UNDETERMINED_SHARE * GAIN]
    if unknown_sensors:
        print(f"  note: the gains of readings {', '.join(unknown_sensors)} are not determined: these hardly stretch")
    if not finger.tip_measured:
        print("  note: a common gain and the bend per pressure cannot be told apart, unless the tip is measured")
    for hold in finger.doubtful:
        print(f"  note: {hold} does not fit free bending: was the finger loaded or touched?")
