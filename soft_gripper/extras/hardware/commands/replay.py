"""soft-gripper replay: estimates shapes from recorded hardware readings; scored by motion capture."""

import argparse
from pathlib import Path

from soft_gripper.commands.viewing import viewed
from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat, write_animation
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.commands.printing import print_replay
from soft_gripper.extras.hardware.recordings import HardwareRecording, find_recordings, recording_paths
from soft_gripper.extras.hardware.replay.arm_estimation import arm_recording
from soft_gripper.extras.hardware.replay.held_out import (
    ArmReplay,
    drawn_rows,
    estimator_rows,
    replay_figure,
    replay_recordings,
)
from soft_gripper.extras.hardware.replay.view import show_replays
from soft_gripper.files.document import require
from soft_gripper.files.output import check_file, lock_folder
from soft_gripper.files.row_table import write_csv
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    paths = recording_paths(options.file, options.described_as, options.data)
    fit_paths = recording_paths(options.fit, options.described_as, options.data) if options.fit else []
    written = ["replay.csv", *(f"{path.stem}.nc" for path in paths)]
    written += [] if options.html is None else [options.html.absolute()]
    out = lock_folder(options.out, written, [*paths, *fit_paths])
    if options.html is not None:
        check_file(options.html)
    recordings = find_recordings(options.file, options.described_as, options.data)
    fitted = find_recordings(options.fit, options.described_as, options.data) if options.fit else None
    finger, gravity = _finger(recordings[0]), recordings[0].gravity
    expected = "give the direction of gravity: the arm bends under its own weight"
    require(gravity is not None, recordings[0].name, "gravity", None, expected)
    assert gravity is not None
    arms = [arm_recording(recording) for recording in recordings]
    rows = estimator_rows(options.estimator, len(arms[0].bodies))
    to_fit = None if fitted is None else [arm_recording(recording) for recording in fitted]
    replay = replay_recordings(arms, to_fit, rows, finger, gravity)
    options.console.table("errors", replay.table)
    options.console.wrote(*_write(out, replay))
    if options.html is not None or options.meshcat:
        _show(options, replay)


def _finger(recording: HardwareRecording) -> Finger:
    """The finger that models the arm.

    Raises:
        InputError: if the description does not name a file with exactly one finger.
    """
    file = recording.config.finger
    require(file is not None, recording.name, "finger", None, "name the URDF with the finger that models the arm")
    assert file is not None
    fingers = expand_urdf(model_path(file)).fingers
    if len(fingers) != 1:
        raise InputError(recording.name, "finger", file, f"contains {len(fingers)} fingers; give a file with one")
    return fingers[0]


def _write(out: Path, replay: ArmReplay) -> list[Path]:
    print_replay(replay)
    write_csv(out / "replay.csv", replay.table)
    save_figure(replay_figure(replay), out / "replay")
    recordings = {out / f"{one.name}.nc": one.signals for one in replay.replayed}
    for file, signals in recordings.items():
        signals.save(file)
    return [out / "replay.csv", out / "replay.png", out / "replay.svg", *recordings]


def _show(options: argparse.Namespace, replay: ArmReplay) -> None:
    meshcat = hidden_meshcat()
    show_replays(meshcat, [one.signals for one in replay.replayed], drawn_rows(replay.rows))
    if options.html is not None:
        write_animation(meshcat, options.html)
        options.console.wrote(options.html)
    if options.meshcat:
        with viewed(meshcat, options.host):
            pass
