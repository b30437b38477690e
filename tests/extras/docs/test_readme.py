"""README: short, and no number in it that a command or a page does not give."""

import re
import shlex
import tomllib
from contextlib import redirect_stdout
from io import StringIO

import pytest
from links import ROOT
from published import differences

from soft_gripper.commands.parser import parsed

README = (ROOT / "README.md").read_text(encoding="utf-8")
CODE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
BLOCKS = CODE.findall(README)
CONTACTS, TRIALS = "docs/extras/studies/contacts.md", "docs/extras/grasps/grasp_trials.md"
REPLAY = "docs/extras/hardware/hardware_replay.md"
# By a sentence of README: the cells with its numbers, by page, beginning of the row, column and places within the cell.
QUOTED = {
    r"mean error (\S+) % of those detected of 200 .* median (\S+) %, 90th percentile (\S+) %\.": [
        (CONTACTS, "mean of 20 samples", 2, slice(None))
    ],
    r"beyond 10 %: (\S+) %, (\S+) %, (\S+) %; (\S+) % detected": [
        (CONTACTS, "equal sections, beyond 10 %", 2, slice(None)),
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
}
# Numbers of sentences that other tests compare: of test_published.py and of tests/benchmarks/test_peers_sentences.py.
COMPARED = (
    r"mean error \S+ mm in the worst scenario; .* four sensors: \S+ mm",
    r"MuJoCo takes \S+ of our computing time for the box grasp, both with steps of 10 ms",
)
MEANT = {"95": "% of the bands", "0.2": "s of an average", "40": "mm to the border of the sections"}


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
        parsed(arguments)


@pytest.mark.parametrize("pattern", QUOTED)
def test_numbers_are_those_of_their_page(pattern):
    printed = re.findall(pattern, README)
    assert len(printed) == 1
    expected = [number for cell in QUOTED[pattern] for number in numbers(*cell)]
    assert differences(" ".join(printed[0]), expected) == []


def test_no_number_is_left_that_nothing_compares():
    text = re.sub(r"`[^`]*`|\]\([^)]*\)|<[^>]*>", "", CODE.sub("", README))
    for pattern in (*QUOTED, *COMPARED):
        text, count = re.subn(pattern, "", text)
        assert count == 1, pattern
    needed = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["requires-python"]
    assert f"Python {needed.removeprefix('>=')} or newer" in text
    left = re.findall(r"(?<![\w.-])\d+(?:\.\d+)?", text.replace(f"Python {needed.removeprefix('>=')}", ""))
    assert set(left) <= set(MEANT)
