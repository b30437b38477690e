"""README: short, and no number in it that a command or a page does not give."""

import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Callable
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path

import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from hardware_files import published
from links import ROOT
from printed_numbers import differences
from published import SENTENCES

from soft_gripper.commands.parser import parse_options

README = (ROOT / "README.md").read_text(encoding="utf-8")
CODE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
BLOCKS = CODE.findall(README)
CONTACTS, TRIALS = "docs/studies/contacts.md", "docs/extras/grasps/grasp_trials.md"
REPLAY = "docs/extras/hardware/hardware_replay.md"
# By a sentence of README: the cells with its numbers, by page, beginning of the row, column and places within the cell.
QUOTED = {
    r"at a third of the length: (\S+) / (\S+) / (\S+) %": [(CONTACTS, "mean of 20 samples", 3, slice(None))],
    r"four sections: (\S+) / (\S+) / (\S+) %": [(CONTACTS, "four sections: mean of 20 samples", 3, slice(None))],
    r"two equal ones, from 10 % of the length on: (\S+) / (\S+) / (\S+) %, with (\S+) % detected": [
        (CONTACTS, "equal sections, beyond 10 %", 3, slice(None)),
        (CONTACTS, "equal sections, beyond 10 %", 1, slice(None)),
    ],
    r"(\d+) of 200 random boxes put down within (\S+) mm, (\d+) of 200 fragile cups": [
        (TRIALS, "put down within 10 mm", 1, slice(None)),
        (TRIALS, "distance from the goal", 1, slice(1, 2)),
        (TRIALS, "put down within 10 mm", 3, slice(None)),
    ],
    r"mean tip error (\S+) mm \(95th percentile (\S+) mm\) of a recorded arm": [
        (REPLAY, "`arcs`, 2 per side", 2, slice(None)),
        (REPLAY, "`arcs`, 2 per side", 3, slice(None)),
    ],
    r"MuJoCo takes (\S+) times our computing time for the box grasp, both with steps of (\S+) ms": [
        ("docs/benchmarks.md", "box grasp | MuJoCo", 6, slice(None)),
        ("docs/benchmarks.md", "box grasp | MuJoCo", 2, slice(1)),
    ],
}
# Numbers of sentences that test_published.py compares with what the evaluation writes.
COMPARED = [pattern.replace("#", r"\S+") for document, pattern in SENTENCES if document == "README.md"]
Numbers = list[float]


def contact_numbers(arguments: list[str], folder: Path) -> Numbers:
    """Errors of the transverse force, %: two unequal sections, four, and two equal ones beyond 10 % of the length."""
    numbers = []
    for borders, more in (("40", []), ("30 60 90", []), ("60", ["--beyond", "0.1"])):
        out = folder / ("beyond" if more else "default")
        if not out.exists():
            line = [sys.executable, "-m", *arguments, *more, "--out", out]
            subprocess.run(line, cwd=ROOT, check=True, capture_output=True)
        key = {"borders": borders, "sensors": "realistic", "averaged": "20", "nominal": "as simulated", "side": "both"}
        (row,) = (row for row in csv_rows(out / "contact_errors.csv") if key.items() <= row.items())
        numbers += [float(row[f"transverse_{statistic}_percent"]) for statistic in ("mean", "median", "90")]
    return [*numbers, float(row["found_percent"])]


def trial_numbers(arguments: list[str], folder: Path) -> Numbers:
    """Successes with boxes, the largest distance, mm, and successes with cups."""
    boxes, cups = (
        _trials([*arguments, "--scenario", scenario], folder / scenario)
        for scenario in ("pick_and_place_box", "pick_and_place_delicate")
    )
    successes = [float(sum(row["success"] == "True" for row in rows)) for rows in (boxes, cups)]
    return [successes[0], max(float(row["placed_error_mm"]) for row in boxes), successes[1]]


def _trials(arguments: list[str], folder: Path) -> list[dict[str, str]]:
    assert soft_gripper(*arguments, "--out", folder).code == 0
    return csv_rows(folder / "trials.csv")


def replay_numbers(arguments: list[str], folder: Path) -> Numbers:
    """Mean and 95th percentile of the tip error, mm, of `arcs` with two sensors, over the trials that braces name."""
    data = published("two_segment_arm").parent
    before, numbers, after = re.split(r"[{}]", arguments[1])
    files = [f"{before}{number}{after}" for number in numbers.split(",")]
    assert soft_gripper("replay", *files, *arguments[2:], "--data", data, "--out", folder).code == 0
    key = {"estimator": "arcs", "sections": "2", "recording": "all", "body": "tip"}
    (row,) = (row for row in csv_rows(folder / "replay.csv") if key.items() <= row.items())
    return [float(row["mean_mm"]), float(row["percentile_95_mm"])]


# By the row of README's table: what runs its command, as printed, and reads the numbers of its sentences.
WRITTEN: dict[str, Callable[[list[str], Path], Numbers]] = {
    "transverse force": contact_numbers,
    "pick and place": trial_numbers,
    "hardware": replay_numbers,
}
MEANT = {
    "95": "% of the bands",
    "0.2": "s of an average",
    "40": "% of the length",
    "200": "contacts",
    "90": "th percentile",
}


def numbers(page: str, beginning: str, column: int, places: slice) -> list[float]:
    """Numbers in a cell of the first row of a page that begins so."""
    text = (ROOT / page).read_text(encoding="utf-8")
    line = next(line for line in text.splitlines() if line.startswith(f"| {beginning}"))
    return [float(number) for number in re.findall(r"\d+(?:\.\d+)?", line.split("|")[1:][column])][places]


def test_readme_is_short():
    assert len(README.split()) <= 900
    before_commands = README[: README.index("```sh")]  # one screen, with the picture
    assert len(before_commands.split()) <= 200


def test_the_first_block_of_python_prints_what_stands_below_it():
    (_, code), (language, shown) = BLOCKS[:2]
    assert language == "text"
    assert len(code.split("\n")) <= 6
    with redirect_stdout(StringIO()) as printed:
        exec(compile(code, "README.md", "exec"), {"__name__": "__main__"})
    assert printed.getvalue() == shown


def test_commands_are_those_of_the_command_line():
    lines = [line for language, text in BLOCKS if language == "sh" for line in text.splitlines()]
    commands = [shlex.split(line, comments=True) for line in lines if line.startswith("soft-gripper ")]
    commands += [
        shlex.split(inline) for inline in re.findall(r"`(soft-gripper [^`]*)`", README) if "--help" not in inline
    ]
    commands = [words for words in commands if "replay" not in words]  # its recordings are not in the repository
    assert len(commands) >= 6
    for _, *arguments in commands:
        parse_options(arguments)


@pytest.mark.parametrize("pattern", QUOTED)
def test_numbers_are_those_of_their_page(pattern):
    printed = re.findall(pattern, README)
    assert len(printed) == 1
    expected = [number for cell in QUOTED[pattern] for number in numbers(*cell)]
    assert differences(" ".join(printed[0]), expected) == []


def table_rows() -> dict[str, list[str]]:
    """Cells of the table of numbers: the measured ones and the command, by the first."""
    lines = README[README.index("## Four numbers") :].splitlines()
    rows = [line.strip("| ").split(" | ") for line in lines if line.startswith("| ")][1:]
    return {name: cells for name, *cells in rows}


def test_each_row_of_numbers_is_compared_with_what_its_command_writes():
    """By `WRITTEN`, but for the evaluation's, which test_published.py compares."""
    assert ["shape", *WRITTEN] == list(table_rows())


@pytest.mark.published
@pytest.mark.parametrize("name", WRITTEN)
def test_a_row_prints_what_its_command_writes(name, tmp_path):
    measured, _, command = table_rows()[name]
    patterns = [pattern for pattern in QUOTED if re.search(pattern, measured)]
    shown = " ".join(" ".join(re.search(pattern, measured).groups()) for pattern in patterns)
    arguments = shlex.split(re.search("`(?:soft-gripper|python -m) ([^`]*)`", command)[1])
    assert differences(shown, WRITTEN[name](arguments, tmp_path)) == []


def test_no_number_is_left_that_nothing_compares():
    text = re.sub(r"`[^`]*`|\]\([^)]*\)|<[^>]*>", "", CODE.sub("", README))
    for pattern in (*QUOTED, *COMPARED):
        text, count = re.subn(pattern, "", text)
        assert count == 1, pattern
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["requires-python"]
    assert f"Python {needed.removeprefix('>=')} or newer" in text
    left = re.findall(r"(?<![\w.-])\d+(?:\.\d+)?", text.replace(f"Python {needed.removeprefix('>=')}", ""))
    assert set(left) <= set(MEANT)
