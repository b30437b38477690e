"""soft-gripper identify: hardware recordings -> a finger file with fitted parameters, and held-out predictions."""

import argparse
from collections.abc import Sequence
from concurrent.futures import Executor
from pathlib import Path

from soft_gripper.extras.hardware.commands.fit_progress import FitProgress
from soft_gripper.extras.hardware.commands.printing import print_bands, print_identified, print_identified_states
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.identified_finger import (
    Identified,
    Tested,
    compared,
    fit_remarks,
    identify,
    identify_figure,
    read_finger,
    read_setup,
    setup_file,
    write_fitted,
)
from soft_gripper.extras.hardware.identification.kept_confidence import CONFIDENCE, ConfidenceConfig, kept_confidence
from soft_gripper.extras.hardware.identification.model_band import STATES, band_rows, learned_band
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    TestedStates,
    compared_states,
    identify_states,
    settled_states,
    states_figure,
)
from soft_gripper.extras.hardware.identification.simulated_motion import measured_motion
from soft_gripper.extras.hardware.recordings import HardwareRecording, find_recordings, recording_paths
from soft_gripper.extras.hardware.weighing import learned_growth
from soft_gripper.files.document import require
from soft_gripper.files.output import check_file
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.executor import open_executor
from soft_gripper.scenario.fitted_states_config import FittedStatesConfig
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    _check_chosen(options)
    opened = open_executor(options.jobs, options.scheduler)
    file = model_path(options.finger)
    setup = setup_file(file)
    paths = recording_paths([*options.file, *options.test], options.described_as, options.data)
    outputs = _outputs(options.out, fits=bool(options.file)) if options.out else []
    for output in outputs:
        check_file(output, [file, *([setup] if setup.exists() else []), *paths])
    model = Model(read_finger(file), read_setup(file))
    fitted, tested = (
        find_recordings(files, options.described_as, options.data) if files else []
        for files in (options.file, options.test)
    )
    is_settled = _is_settled([*fitted, *tested])
    with opened as executor:
        result = (_of_states if is_settled else _of_motions)(model, fitted, tested, options, executor)
        if isinstance(result, TestedStates):
            print_identified_states(result)
        else:
            print_identified(result)
        kept, known = (
            _kept(result)
            if isinstance(result, Identified | IdentifiedStates)
            else (STATES.read(file), CONFIDENCE.read(file))
        )
        bands = [] if kept is None else band_rows(kept, result, known, executor.map)
    if kept is not None:
        print_bands(bands)
        options.console.table("bands", bands)
    if options.out:
        _write(result, file, outputs)
        if kept is not None and known is not None and isinstance(result, Identified | IdentifiedStates):
            STATES.write(options.out, kept)
            CONFIDENCE.write(options.out, known)
    options.console.table("scores", result.scores)
    options.console.wrote(*outputs)


def _kept(identified: Identified | IdentifiedStates) -> tuple[FittedStatesConfig, ConfidenceConfig]:
    """The states of a fit and the confidence in it, as they are kept beside the finger."""
    growth = learned_growth(identified) if isinstance(identified, IdentifiedStates) else 0.0
    return learned_band(identified), kept_confidence(identified.fit.free, identified.confidence, growth)


def _check_chosen(options: argparse.Namespace) -> None:
    """Raises an InputError if there is nothing to do, or options of a fit are given without one, or missing."""
    require(bool(options.file or options.test), "identify", "FILE", "", "give recordings to fit to, or --test ones")
    for name, value in (("--free", options.free), ("--out", options.out)) if options.file else ():
        require(bool(value), "identify", name, "", "is required to fit a finger to recordings")
    expected = "nothing is fitted without recordings to fit to: leave it out, or give FILE"
    require(bool(options.file or not options.free), "identify", "--free", " ".join(options.free), expected)


def _of_motions(
    model: Model,
    fitted: Sequence[HardwareRecording],
    tested: Sequence[HardwareRecording],
    options: argparse.Namespace,
    executor: Executor,
) -> Tested:
    motions, tests = ([measured_motion(recording) for recording in role] for role in (fitted, tested))
    if not motions:
        return compared(model, tests, executor)
    chosen = executor, options.starts, options.seed, _progress(options), model.setup
    return identify(model.finger, options.free, motions, tests, *chosen)


def _of_states(
    model: Model,
    fitted: Sequence[HardwareRecording],
    tested: Sequence[HardwareRecording],
    options: argparse.Namespace,
    executor: Executor,
) -> TestedStates:
    states, tests = ([settled_states(recording, model.finger) for recording in role] for role in (fitted, tested))
    if not states:
        return compared_states(model, tests)
    chosen = executor, options.starts, options.seed, _progress(options), model.setup
    return identify_states(model.finger, options.free, states, tests, *chosen)


def _progress(options: argparse.Namespace) -> FitProgress:
    """Reports a search, and writes what it has found so far."""
    file = model_path(options.finger)
    return FitProgress("fitting", lambda model, remark: write_fitted(file, options.out, model, [remark]))


def _outputs(out: Path, fits: bool) -> list[Path]:
    """The files that are written: those of a fit, or of a test alone."""
    tables = [out.with_suffix(suffix) for suffix in (".csv", ".png", ".svg")]
    return [out, setup_file(out), STATES.file(out), CONFIDENCE.file(out), *tables] if fits else tables


def _write(found: Tested | TestedStates, file: Path, outputs: Sequence[Path]) -> None:
    of_suffix = {output.suffix: output for output in outputs}
    if isinstance(found, Identified | IdentifiedStates):
        write_fitted(file, of_suffix[".urdf"], found.model, fit_remarks(found.confidence))
    write_csv(of_suffix[".csv"], found.scores)
    figure = states_figure(found) if isinstance(found, TestedStates) else identify_figure(found)
    save_figure(figure, of_suffix[".csv"].with_suffix(""))


def _is_settled(recordings: Sequence[HardwareRecording]) -> bool:
    """Whether these are of settled states; they may not be mixed with motions."""
    settled = [recording.name for recording in recordings if recording.config.event == "settled"]
    for recording in recordings if settled else ():
        expected = f"'{settled[0]}' is of settled states: identify motions by themselves"
        require(recording.name in settled, recording.name, "event", recording.config.event, expected)
    return bool(settled)
