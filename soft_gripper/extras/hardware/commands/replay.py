"""soft-gripper replay: estimates from recorded hardware readings; scored by motion capture, or by a measured force."""

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from soft_gripper.diagrams.view.meshcat_view import hidden_meshcat, write_animation
from soft_gripper.extras.hardware.commands.printing import print_measured, print_replay
from soft_gripper.extras.hardware.finger_logs import load_log, read_finger_logs
from soft_gripper.extras.hardware.recordings import find_recordings, recording_paths
from soft_gripper.extras.hardware.replay.held_out import ArmReplay, drawn_rows, replay, replay_figure
from soft_gripper.extras.hardware.replay.measured_scores import measured_figure, replay_measured
from soft_gripper.extras.hardware.replay.view import show_replays
from soft_gripper.extras.page.viewing import show_meshcat
from soft_gripper.files.document import require
from soft_gripper.files.output import check_file, lock_folder
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import save_figure


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    paths = recording_paths(options.file, options.described_as, options.data)
    if options.scenario is None and options.bench is None:
        _run_arm(options, paths)
    else:
        _run_finger(options, paths)


def _run_finger(options: argparse.Namespace, paths: Sequence[Path]) -> None:
    """Replays fingers with strain sensors, compared with instruments."""
    ignored_options = {"--fit": options.fit, "--html": options.html, "--meshcat": options.meshcat or None}
    for name, value in ignored_options.items():
        require(value is None, "replay", name, value, "is for an arm and motion capture; leave it out with --scenario")
    described_by = [Path(file) for file in (options.scenario, options.bench, options.described_as) if file is not None]
    output_names = ["replay.csv", "scores.csv", "replay.png", "replay.svg"]
    out = lock_folder(options.out, output_names, [*paths, *(file for file in described_by if file.suffix)])
    log = load_log(options.scenario, options.bench, options.described_as, "replay", options.set)
    assert log is not None
    logs = [finger_log for path in paths for finger_log in read_finger_logs(path, log)]
    replayed = replay_measured(logs, log.scenario, options.estimator or [log.scenario.estimator.type], options.zero)
    print_measured(replayed)
    options.console.document["instruments"] = {
        kind: asdict(instrument) for kind, instrument in replayed.instruments.items()
    }
    options.console.table("presses", replayed.presses)
    options.console.table("scores", replayed.scores)
    write_csv(out / "replay.csv", replayed.presses)
    write_csv(out / "scores.csv", replayed.scores)
    save_figure(measured_figure(replayed), out / "replay")
    recordings = {out / f"{run.log.name}.nc": run.recording() for run in replayed.runs}
    for file, recording in recordings.items():
        recording.save(file)
    options.console.wrote(*(out / name for name in output_names), *recordings)


def _run_arm(options: argparse.Namespace, paths: Sequence[Path]) -> None:
    """Replays arms with wires, compared with motion capture."""
    require(not options.set, "replay", "--set", options.set, "changes the scenario of --scenario; give that too")
    fit_paths = recording_paths(options.fit, options.described_as, options.data) if options.fit else []
    output_names = ["replay.csv", *(f"{path.stem}.nc" for path in paths)]
    output_names += [] if options.html is None else [options.html.absolute()]
    out = lock_folder(options.out, output_names, [*paths, *fit_paths])
    if options.html is not None:
        check_file(options.html)
    recordings = find_recordings(options.file, options.described_as, options.data)
    fitted_recordings = find_recordings(options.fit, options.described_as, options.data) if options.fit else None
    replayed = replay(recordings, fitted_recordings, options.estimator, options.zero)
    options.console.table("errors", replayed.table)
    options.console.wrote(*_write(out, replayed))
    if options.html is not None or options.meshcat:
        _show(options, replayed)


def _write(out: Path, replay_: ArmReplay) -> list[Path]:
    print_replay(replay_)
    write_csv(out / "replay.csv", replay_.table)
    save_figure(replay_figure(replay_), out / "replay")
    recordings = {out / f"{run.name}.nc": run.signals for run in replay_.replayed}
    for file, signals in recordings.items():
        signals.save(file)
    return [out / "replay.csv", out / "replay.png", out / "replay.svg", *recordings]


def _show(options: argparse.Namespace, replay_: ArmReplay) -> None:
    meshcat = hidden_meshcat()
    show_replays(meshcat, [run.signals for run in replay_.replayed], drawn_rows(replay_.rows))
    if options.html is not None:
        write_animation(meshcat, options.html)
        options.console.wrote(options.html)
    if options.meshcat:
        with show_meshcat(meshcat, options.host):
            pass
