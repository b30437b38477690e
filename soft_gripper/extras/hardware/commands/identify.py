"""soft-gripper identify: hardware recordings -> a finger file with fitted parameters, and held-out predictions."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from soft_gripper.extras.hardware.commands.printing import (
    FitProgress,
    print_bands,
    print_identified,
    print_identified_states,
)
from soft_gripper.extras.hardware.identification.confidence import CONFIDENCE, kept_confidence
from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.identification.identified_finger import (
    SETUP,
    Identified,
    Tested,
    compare_motions,
    fit_remarks,
    identify,
    identify_figure,
    read_finger,
    read_setup,
    write_fitted,
)
from soft_gripper.extras.hardware.identification.model_band import STATES, band_rows, learned_band
from soft_gripper.extras.hardware.identification.settled_states import (
    IdentifiedStates,
    TestedStates,
    compare_states,
    identify_states,
    settled_states,
    states_figure,
)
from soft_gripper.extras.hardware.identification.simulated_motion import measured_motion
from soft_gripper.extras.hardware.recordings import HardwareRecording, find_recordings, recording_paths
from soft_gripper.extras.hardware.weighing import learned_growth
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.files.document import require
from soft_gripper.files.output import check_file
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.model_files import model_path


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    _check_options(options)
    processes = open_executor(options.jobs, options.scheduler)
    file = model_path(options.finger)
    setup = SETUP.file(file)
    paths = recording_paths([*options.file, *options.test], options.described_as, options.data)
    outputs = _outputs(options.out, fits=bool(options.file)) if options.out else []
    for output in outputs:
        check_file(output, [file, *([setup] if setup.exists() else []), *paths])
    model = Model(read_finger(file), read_setup(file))
    fit_runs, tested = (
        find_recordings(files, options.described_as, options.data) if files else []
        for files in (options.file, options.test)
    )
    is_settled = _are_settled([*fit_runs, *tested])
    with processes as executor:
        report = FitProgress("fitting", lambda model, remark: write_fitted(file, options.out, model, [remark]))
        search_options = executor, options.starts, options.seed, report, model.setup
        result: Tested | TestedStates
        if is_settled:
            states, test_states = ([settled_states(run, model.finger) for run in runs] for runs in (fit_runs, tested))
            if states:
                result = identify_states(model.finger, options.free, states, test_states, *search_options)
            else:
                result = compare_states(model, test_states)
            print_identified_states(result)
        else:
            motions, test_motions = ([measured_motion(run) for run in runs] for runs in (fit_runs, tested))
            if motions:
                result = identify(model.finger, options.free, motions, test_motions, *search_options)
            else:
                result = compare_motions(model, test_motions, executor)
            print_identified(result)
        kept_states, confidence = STATES.read(file), CONFIDENCE.read(file)
        if isinstance(result, Identified | IdentifiedStates):
            growth = learned_growth(result) if isinstance(result, IdentifiedStates) else 0.0
            kept_states, confidence = learned_band(result), kept_confidence(result.fit.free, result.confidence, growth)
        bands = [] if kept_states is None else band_rows(kept_states, result, confidence, executor.map)
    if kept_states is not None:
        print_bands(bands)
        options.console.table("bands", bands)
    if options.out:
        if isinstance(result, Identified | IdentifiedStates) and kept_states is not None and confidence is not None:
            write_fitted(file, options.out, result.model, fit_remarks(result.confidence))
            STATES.write(options.out, kept_states)
            CONFIDENCE.write(options.out, confidence)
        write_csv(options.out.with_suffix(".csv"), result.scores)
        figure = states_figure(result) if isinstance(result, TestedStates) else identify_figure(result)
        save_figure(figure, options.out.with_suffix(""))
    options.console.table("scores", result.scores)
    options.console.wrote(*outputs)


def _check_options(options: argparse.Namespace) -> None:
    """Raises an InputError if there is nothing to do, or if options of a fit are missing or have no fit."""
    require(bool(options.file or options.test), "identify", "FILE", "", "give recordings to fit to, or --test ones")
    for name, value in (("--free", options.free), ("--out", options.out)) if options.file else ():
        require(bool(value), "identify", name, "", "is required to fit a finger to recordings")
    expected = "nothing is fitted without recordings to fit to: leave it out, or give FILE"
    require(bool(options.file or not options.free), "identify", "--free", " ".join(options.free), expected)


def _outputs(out: Path, fits: bool) -> list[Path]:
    """Paths of the output files of a fit, or of a test alone."""
    tables = [out.with_suffix(suffix) for suffix in (".csv", ".png", ".svg")]
    return [out, SETUP.file(out), STATES.file(out), CONFIDENCE.file(out), *tables] if fits else tables


def _are_settled(recordings: Sequence[HardwareRecording]) -> bool:
    """Whether recordings are of settled states; they may not be mixed with motions."""
    settled_names = [recording.name for recording in recordings if recording.config.event == "settled"]
    for recording in recordings if settled_names else ():
        expected = f"'{settled_names[0]}' is of settled states: identify motions by themselves"
        require(recording.name in settled_names, recording.name, "event", recording.config.event, expected)
    return bool(settled_names)
