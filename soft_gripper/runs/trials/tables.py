"""The tables of trials in a folder: they say what they are of, and what was cut short goes on from them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.csv_table import cells, read_csv, write_csv
from soft_gripper.files.output import atomic_file
from soft_gripper.files.row_sums import note_changed, read_sums, row_sum, sums_file, write_sums
from soft_gripper.files.text import read_text
from soft_gripper.runs.executor import Call
from soft_gripper.runs.trials.trial import DetailRow, Trial, TrialRow
from soft_gripper.scenario.scenario import Scenario
from soft_gripper.scenario.scenario_file import dump_scenario

ABOUT = "trials.yaml"
TABLES = ("trials.csv", "trials_details.csv")
FIGURE = "trials"


def begin(out: Path, scenarios: Mapping[str, Scenario], seed: int, resume: bool) -> dict[Call, Trial]:
    """Readies a folder for trials; those that are resumed are returned, by the calls of `run_trial`.

    Args:
        out: the folder.
        scenarios: by the files that they are from.
        seed: of the trials.
        resume: whether those that are there are kept.

    Raises:
        InputError: if what is there is of another seed or of other scenarios.
    """
    about = "\n".join([f"seed: {seed}", *(f"# {Path(file).stem}\n{dump_scenario(s)}" for file, s in scenarios.items())])
    if resume and (out / ABOUT).is_file():
        if read_text(out / ABOUT) != about:
            expected = "holds trials of another seed or other scenarios; give those, or another --out"
            raise InputError("grasp-trials", "--resume", str(out), expected)
        return _read(out, {Path(file).stem: file for file in scenarios}, seed)
    for stale in (ABOUT, *TABLES, sums_file(out / TABLES[0]).name, f"{FIGURE}.png", f"{FIGURE}.svg"):
        (out / stale).unlink(missing_ok=True)
    with atomic_file(out / ABOUT) as partial:
        partial.write_text(about, encoding="utf-8")
    return {}


def _read(out: Path, files: Mapping[str, str], seed: int) -> dict[Call, Trial]:
    """The trials that are in both tables, one of which is written first, and as they were written in both."""
    if not all((out / table).is_file() for table in TABLES):
        return {}
    rows = read_csv(out / TABLES[0], TrialRow)
    details = {(row.scenario, row.trial): row for row in read_csv(out / TABLES[1], DetailRow)}
    found = [Trial(row, details[key]) for row in rows if (key := (row.scenario, row.trial)) in details]
    sums = read_sums(out / TABLES[0])
    kept = [trial for trial in found if _sum(trial) in sums]
    note_changed(out / TABLES[0], len(found) - len(kept))
    return {(files[trial.row.scenario], seed, trial.row.trial): trial for trial in kept}


def write_tables(out: Path, trials: Sequence[Trial]) -> None:
    """Writes both tables, each whole, then the checksums of the trials."""
    write_csv(out / TABLES[0], [trial.row for trial in trials])
    write_csv(out / TABLES[1], [trial.details for trial in trials])
    write_sums(out / TABLES[0], map(_sum, trials))


def _sum(trial: Trial) -> str:
    return row_sum([*cells(trial.row), *cells(trial.details)])
