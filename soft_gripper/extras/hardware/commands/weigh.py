"""soft-gripper weigh: the load at the tip of an identified finger, from recorded settled states."""

import argparse

from soft_gripper.extras.hardware.identification.confidence import CONFIDENCE
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.identified_finger import read_finger, read_setup
from soft_gripper.extras.hardware.identification.model_band import STATES
from soft_gripper.extras.hardware.identification.settled_states import SettledStates, settled_states
from soft_gripper.extras.hardware.recordings import find_recordings, recording_paths
from soft_gripper.extras.hardware.weighing import KeptFit, weigh, weighing_figure
from soft_gripper.files.document import require
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_rows
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    file = model_path(options.finger)
    file_names = options.file if options.tare is None else [*options.file, options.tare]
    paths = recording_paths(file_names, options.described_as, options.data)
    out = lock_folder(options.out, [f"weigh{suffix}" for suffix in (".csv", ".png", ".svg")], [file, *paths])
    finger, setup = read_finger(file), read_setup(file)
    recordings = find_recordings(options.file, options.described_as, options.data)
    for recording in recordings:
        expected = "only recordings of settled states are weighed"
        require(recording.config.event == "settled", recording.name, "event", recording.config.event, expected)
    tare = None if options.tare is None else _tare(finger, options)
    states = [settled_states(recording, finger) for recording in recordings]
    kept_fit, confidence = STATES.read(file), CONFIDENCE.read(file)
    fit = KeptFit(kept_fit, confidence) if kept_fit is not None and confidence is not None else None
    weighings = [row for run in states for row in weigh(Model(finger, setup), run, options.window, tare, fit)]
    title = "load at the tip, its band of 95 %, and the load in the file's name; last row of a recording: all of it"
    print_rows(weighings, title)
    if fit is None:
        missing_files = f"{STATES.file(file).name} and {CONFIDENCE.file(file).name} are not beside the finger"
        print(f"WARNING: the bands take the finger for exact: {missing_files}")
    for row in {row.recording: row for row in weighings}.values():
        if row.far_percent > 0:
            print(f"WARNING: {row.recording}: {row.far_percent:.0f} % of it is far from what was fitted")
    options.console.table("loads", weighings, out / "weigh.csv")
    save_figure(weighing_figure(weighings), out / "weigh")
    options.console.wrote(*(out / f"weigh{suffix}" for suffix in (".csv", ".png", ".svg")))


def _tare(finger: Finger, options: argparse.Namespace) -> SettledStates:
    """Reads the states of the recording without a load."""
    (recording,) = find_recordings([options.tare], options.described_as, options.data)
    named_mass = recording.load_mass
    require(named_mass == 0, recording.name, "--tare", f"{1e3 * named_mass:g} g", "give a recording without a load")
    return settled_states(recording, finger)
