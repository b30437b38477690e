"""soft-gripper study hardware: identifies and replays the published hardware experiments, and checks claims."""

import argparse
import sys
from pathlib import Path

from soft_gripper.commands.printing import print_claims
from soft_gripper.extras.hardware.commands.printing import print_identified, print_replay
from soft_gripper.extras.hardware.identification.identified_finger import Identified, with_finger, write_text
from soft_gripper.extras.hardware.published import (
    ARM,
    BEAM,
    SEGMENT,
    Experiment,
    hardware_claims,
    hardware_figure,
    identify_published,
    published_recordings,
)
from soft_gripper.extras.hardware.replay.held_out import replay
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    opened = open_executor(options.jobs, options.scheduler)
    recordings = published_recordings(options.data)
    out = lock_folder(options.out)
    arm = replay(list(recordings[ARM].values()))
    print_replay(arm)
    write_csv(out / f"{ARM}.csv", arm.table)
    with opened as executor:
        beam, segment = (
            _written(
                out, experiment, identify_published(experiment, recordings[experiment.description], executor, _report)
            )
            for experiment in (BEAM, SEGMENT)
        )
    save_figure(hardware_figure(beam, segment, arm), out / "hardware")
    found = hardware_claims(beam, segment, arm.table)
    print_claims(found)
    options.console.table("claims", found, out / "claims.csv")
    fingers = [f"{experiment.description}{suffix}" for experiment in (BEAM, SEGMENT) for suffix in (".urdf", ".csv")]
    options.console.wrote(
        *(out / file for file in (*fingers, f"{ARM}.csv", "claims.csv", "hardware.png", "hardware.svg"))
    )
    return 0 if all(claim.holds for claim in found) else 1


def _written(out: Path, experiment: Experiment, found: Identified) -> Identified:
    """Writes and prints the identified parameters."""
    print(file=sys.stderr)
    print(f"\n{experiment.description}: fitted to {', '.join(experiment.fitted)}")
    print_identified(found)
    write_text(out / f"{experiment.description}.urdf", with_finger(experiment.finger_file, found.model.finger))
    write_csv(out / f"{experiment.description}.csv", found.scores)
    return found


def _report(experiment: str, error: float) -> None:
    text = f"\r{experiment}, fitting: marker error {100 * error:.2f} % of the largest displacement "
    print(text, end="", file=sys.stderr, flush=True)
