"""soft-gripper identify: hardware recordings -> a finger file with fitted parameters, and held-out predictions."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from soft_gripper.commands.tables import print_defects, print_identified, print_identified_states
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.document import require
from soft_gripper.files.output import check_file, keep_inputs
from soft_gripper.hardware.identification.identified_finger import (
    Identified,
    identify,
    identify_figure,
    read_finger,
    with_finger,
    write_finger,
)
from soft_gripper.hardware.identification.settled_states import (
    IdentifiedStates,
    identify_states,
    settled_states,
    states_figure,
)
from soft_gripper.hardware.identification.simulated_motion import measured_motion
from soft_gripper.hardware.recordings import HardwareRecording, find_recordings, recording_paths
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    opened = open_executor(options.jobs, options.scheduler)
    file, out = model_path(options.finger), options.out
    finger = read_finger(file)
    recordings = [_recordings(files, options) for files in (options.file, options.test)]
    is_settled = _is_settled([*recordings[0], *recordings[1]])
    paths = recording_paths([*options.file, *options.test], options.described_as, options.data)
    keep_inputs([file, *paths], _outputs(out))
    check_file(out)
    found: Identified | IdentifiedStates
    with opened as executor:
        chosen = executor, options.starts, options.seed, _report
        if is_settled:
            states = [[settled_states(recording, finger) for recording in role] for role in recordings]
            found = identify_states(finger, options.free, states[0], states[1], *chosen)
        else:
            motions = [[measured_motion(recording) for recording in role] for role in recordings]
            found = identify(finger, options.free, motions[0], motions[1], *chosen)
    print(file=sys.stderr)
    text = with_finger(file, found.model.finger)
    if isinstance(found, IdentifiedStates):
        print_identified_states(found)
        figure = states_figure(found)
    else:
        print_identified(found)
        figure = identify_figure(found)
    save_figure(figure, out.with_suffix(""))
    write_csv(out.with_suffix(".csv"), found.scores)
    write_finger(out, text)
    options.console.table("scores", found.scores)
    options.console.wrote(*_outputs(out))


def _outputs(out: Path) -> list[Path]:
    return [out.with_suffix(suffix) for suffix in (".urdf", ".csv", ".png", ".svg")]


def _recordings(files: list[str], options: argparse.Namespace) -> list[HardwareRecording]:
    recordings = find_recordings(files, options.described_as, options.data) if files else []
    print_defects(recordings)
    return recordings


def _is_settled(recordings: Sequence[HardwareRecording]) -> bool:
    """Whether these are of settled states; they may not be mixed with motions."""
    settled = [recording.name for recording in recordings if recording.config.event == "settled"]
    for recording in recordings if settled else ():
        expected = f"'{settled[0]}' is of settled states: identify motions by themselves"
        require(recording.name in settled, recording.name, "event", recording.config.event, expected)
    return bool(settled)


def _report(error: float) -> None:
    print(f"\rfitting: marker error {100 * error:.2f} % ", end="", file=sys.stderr, flush=True)
