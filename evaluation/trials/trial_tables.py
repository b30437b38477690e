"""The tables of trials in a folder: they say what they are of, and what was cut short goes on from them."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import dump_scenario
from soft_gripper.errors import InputError
from soft_gripper.evaluation.csv_table import read_csv, write_csv
from soft_gripper.evaluation.executor.executor import Call
from soft_gripper.evaluation.trials.trial import DetailRow, Trial, TrialRow
from soft_gripper.files import atomic_file

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
        if (out / ABOUT).read_text(encoding="utf-8") != about:
            expected = "holds trials of another seed or other scenarios; give those, or another --out"
            raise InputError("grasp-trials", "--resume", str(out), expected)
        return _read(out, {Path(file).stem: file for file in scenarios}, seed)
    for stale in (ABOUT, *TABLES, f"{FIGURE}.png", f"{FIGURE}.svg"):
        (out / stale).unlink(missing_ok=True)
    with atomic_file(out / ABOUT) as partial:
        partial.write_text(about, encoding="utf-8")
    return {}


def _read(out: Path, files: Mapping[str, str], seed: int) -> dict[Call, Trial]:
    """The trials that are in both tables, one of which is written first."""
    if not all((out / table).is_file() for table in TABLES):
        return {}
    rows = read_csv(out / TABLES[0], TrialRow)
    details = {(row.scenario, row.trial): row for row in read_csv(out / TABLES[1], DetailRow)}
    return {
        (files[row.scenario], seed, row.trial): Trial(row, details[row.scenario, row.trial])
        for row in rows
        if (row.scenario, row.trial) in details
    }


def write_tables(out: Path, trials: Sequence[Trial]) -> None:
    """Writes both tables, each whole."""
    write_csv(out / TABLES[0], [trial.row for trial in trials])
    write_csv(out / TABLES[1], [trial.details for trial in trials])
