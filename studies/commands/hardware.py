"""python -m studies hardware: identifies and replays the published hardware experiments, and checks claims."""

import argparse
from concurrent.futures import Executor
from pathlib import Path

from soft_gripper.extras.hardware.commands.printing import FitProgress, print_identified, print_replay
from soft_gripper.extras.hardware.identification.identified_finger import Identified, fit_remarks, write_fitted
from soft_gripper.extras.hardware.replay.held_out import replay
from soft_gripper.extras.paper.commands.printing import print_claims
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import save_figure
from studies.hardware.published import (
    ARM,
    BEAM,
    SEGMENT,
    Experiment,
    Recordings,
    hardware_claims,
    hardware_figure,
    identify_published,
    published_recordings,
)


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
            _identify(out, experiment, recordings[experiment.description], executor) for experiment in (BEAM, SEGMENT)
        )
    save_figure(hardware_figure(beam, segment, arm), out / "hardware")
    claims = hardware_claims(beam, segment, arm.table)
    print_claims(claims)
    options.console.table("claims", claims, out / "claims.csv")
    suffixes = (".urdf", ".setup.yaml", ".csv")
    fingers = [f"{experiment.description}{suffix}" for experiment in (BEAM, SEGMENT) for suffix in suffixes]
    options.console.wrote(
        *(out / file for file in (*fingers, f"{ARM}.csv", "claims.csv", "hardware.png", "hardware.svg"))
    )
    return 0 if all(claim.holds for claim in claims) else 1


def _identify(out: Path, experiment: Experiment, recordings: Recordings, executor: Executor) -> Identified:
    """Identifies a finger, prints and writes its parameters; its file has the best one so far."""
    initial, name = experiment.finger_file, experiment.description
    file = out / f"{name}.urdf"
    progress = FitProgress(name, lambda model, remark: write_fitted(initial, file, model, [remark]))
    identified = identify_published(experiment, recordings, executor, progress)
    print(f"\n{name}: fitted to {', '.join(experiment.fitted)}")
    print_identified(identified)
    write_fitted(initial, file, identified.model, fit_remarks(identified.confidence))
    write_csv(out / f"{name}.csv", identified.scores)
    return identified
