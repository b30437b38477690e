"""Numbers that documents print, compared with what they should be, to the last digit that is printed.

A table is found by its header, a sentence by a pattern; both may move and be reworded around their numbers.
"""

import re
from collections.abc import Iterator, Sequence

Numbers = list[float]
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def table_problems(text: str, header: str, expected: Sequence[Numbers]) -> list[str]:
    """What is wrong with the table of that header in a document."""
    found = [rows for rows in _tables(text) if begins_with(rows[0], header)]
    if len(found) != 1:
        return [f"{len(found)} tables begin with '{header}'"]
    (_, *rows), problems = found[0], []
    if len(rows) != len(expected):
        return [f"'{header}': {len(rows)} rows, not {len(expected)}"]
    for cells, numbers in zip(rows, expected, strict=True):
        problems += [f"'{' | '.join(cells)}': {problem}" for problem in differences(" ".join(cells), numbers)]
    return problems


def sentence_problems(text: str, pattern: str, expected: Numbers) -> list[str]:
    """What is wrong with the sentence of that pattern, in which # is a number."""
    found = re.findall(pattern.replace("#", f"({NUMBER.pattern})"), " ".join(text.split()))
    if len(found) != 1:
        return [f"{len(found)} sentences are '{pattern}'"]
    return differences(" ".join([found[0]] if isinstance(found[0], str) else found[0]), expected)


_NEAR = 0.01  # of the last digit printed: by so much versions of Drake differ, and a few numbers round apart


def differences(text: str, expected: Numbers) -> list[str]:
    """Numbers in a text that are not those expected, as they would be printed with as many digits."""
    printed = NUMBER.findall(text)
    if len(printed) != len(expected):
        return [f"{len(printed)} numbers, not {len(expected)}"]
    return [
        f"{word} is printed, {number:z.{len(word)}g} was written"
        for word, number in zip(printed, expected, strict=True)
        if word not in _as_printed(number, len(word.partition(".")[2]))
    ]


def _as_printed(number: float, digits: int) -> set[str]:
    near = _NEAR * 10.0**-digits
    return {f"{value:z.{digits}f}" for value in (number - near, number, number + near)}


def _tables(text: str) -> Iterator[list[list[str]]]:
    """Rows of cells; the first is the header."""
    for block in re.findall(r"(?:^\|.*\n?)+", text, re.MULTILINE):
        header, _, *rows = block.splitlines()
        yield [cells_of(line) for line in (header, *rows)]


def begins_with(cells: Sequence[str], header: str) -> bool:
    """Whether the first cells of a table are those of a header."""
    wanted = cells_of(f"|{header}|")
    return list(cells[: len(wanted)]) == wanted


def cells_of(line: str) -> list[str]:
    """Cells of a line of a table."""
    return [cell.replace("*", "").strip() for cell in line.strip()[1:-1].split("|")]


def printed(page: str, pattern: str) -> list[str]:
    """The numbers that a page has at the groups of a pattern."""
    match = re.search(pattern, page)
    assert match is not None, pattern
    return list(match.groups())
