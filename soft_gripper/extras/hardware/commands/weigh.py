"""soft-gripper weigh: the load at the tip of an identified finger, from recorded settled states."""

import argparse
from dataclasses import astuple

from soft_gripper.commands.tables import print_table
from soft_gripper.extras.hardware.identification.identified_finger import read_finger
from soft_gripper.extras.hardware.identification.settled_states import SettledStates, settled_states
from soft_gripper.extras.hardware.recordings import find_recordings, recording_paths
from soft_gripper.extras.hardware.weighing import weigh, weighing_figure
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.document import require
from soft_gripper.files.output import lock_folder
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    file = model_path(options.finger)
    named = options.file if options.tare is None else [*options.file, options.tare]
    read = recording_paths(named, options.described_as, options.data)
    out = lock_folder(options.out, [f"weigh{suffix}" for suffix in (".csv", ".png", ".svg")], [file, *read])
    finger = read_finger(file)
    recordings = find_recordings(options.file, options.described_as, options.data)
    for recording in recordings:
        expected = "only recordings of settled states are weighed"
        require(recording.config.event == "settled", recording.name, "event", recording.config.event, expected)
    tare = None if options.tare is None else _tare(finger, options)
    states = [settled_states(recording, finger) for recording in recordings]
    weighings = [row for of in states for row in weigh(finger, of, options.window, tare)]
    columns = {"recording": "", "from [s]": ".0f", "to [s]": ".0f", "rows": "d"}
    columns |= {"load [g]": ".1f", "band, 95 % [g]": ".1f", "in the file's name [g]": "g"}
    print_table(columns, map(astuple, weighings), "load at the tip; the last row of a recording is over all of it")
    write_csv(out / "weigh.csv", weighings)
    save_figure(weighing_figure(weighings), out / "weigh")
    options.console.table("loads", weighings)
    options.console.wrote(*(out / f"weigh{suffix}" for suffix in (".csv", ".png", ".svg")))


def _tare(finger: Finger, options: argparse.Namespace) -> SettledStates:
    """The states of the recording without a load."""
    (recording,) = find_recordings([options.tare], options.described_as, options.data)
    named = recording.load_mass
    require(named == 0, recording.name, "--tare", f"{1e3 * named:g} g", "give a recording without a load")
    return settled_states(recording, finger)
