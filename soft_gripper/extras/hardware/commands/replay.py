"""soft-gripper replay: estimates shapes from recorded hardware readings; scored by motion capture."""

import argparse
from pathlib import Path

from soft_gripper.commands.viewing import viewed
from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat, write_animation
from soft_gripper.extras.hardware.commands.printing import print_replay
from soft_gripper.extras.hardware.recordings import find_recordings, recording_paths
from soft_gripper.extras.hardware.replay.held_out import ArmReplay, drawn_rows, replay, replay_figure
from soft_gripper.extras.hardware.replay.view import show_replays
from soft_gripper.files.output import check_file, lock_folder
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import save_figure


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
    found = replay(recordings, fitted, options.estimator)
    options.console.table("errors", found.table)
    options.console.wrote(*_write(out, found))
    if options.html is not None or options.meshcat:
        _show(options, found)


def _write(out: Path, found: ArmReplay) -> list[Path]:
    print_replay(found)
    write_csv(out / "replay.csv", found.table)
    save_figure(replay_figure(found), out / "replay")
    recordings = {out / f"{one.name}.nc": one.signals for one in found.replayed}
    for file, signals in recordings.items():
        signals.save(file)
    return [out / "replay.csv", out / "replay.png", out / "replay.svg", *recordings]


def _show(options: argparse.Namespace, found: ArmReplay) -> None:
    meshcat = hidden_meshcat()
    show_replays(meshcat, [one.signals for one in found.replayed], drawn_rows(found.rows))
    if options.html is not None:
        write_animation(meshcat, options.html)
        options.console.wrote(options.html)
    if options.meshcat:
        with viewed(meshcat, options.host):
            pass
