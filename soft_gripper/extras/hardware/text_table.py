"""Text of loggers, spreadsheets and scripts -> a table.

How a file is written is found from what is known of it, the names of its columns: the separator and the line of names
are those that show most of them, and the decimal sign is the one with which most rows are numbers. What is not a row
of the table, or not one of numbers, is left out with a note. Whatever is in columns that are not needed is ignored.
"""

import csv
import math
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.clock_times import is_clock, seconds_of
from soft_gripper.extras.hardware.foreign_files import foreign_binary, foreign_text
from soft_gripper.extras.hardware.table import Columns, Table
from soft_gripper.files.json_text import parse_json
from soft_gripper.files.notes import LEFT_OUT, MENDED, note
from soft_gripper.files.number import is_number, number
from soft_gripper.files.text import decode, read_bytes

_SPACE = " "  # any number of spaces and tabs
_SEPARATORS = "\t", ";", ",", "|", _SPACE
_COMMENT = re.compile(r"\s*+(?:#|%|//)++ *+")
_HEAD = 1000  # lines in which the names of columns are looked for
_LEAST_SHARE = 0.05  # of rows that must be numbers, or the form of the file was not recognised
_MISSING = frozenset(
    (
        *("", "na", "n/a", "#n/a", "null", "none", "-", "--", "---", "?", "#div/0!", "#value!"),
        *("nan", "+nan", "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"),
    )
)
_INFINITE = frozenset(("inf", "infinity"))  # refused by the table, with its row
_SIGNS = {".": ",", ",": "."}  # a decimal sign, and what may separate thousands beside it
_BLANKS = "'\u2019\xa0\u2007\u2009\u202f"  # what separates nothing else: apostrophes, and spaces that do not break
_THOUSANDS = {  # a common space can also lie between two numbers, unless a decimal sign follows
    sign: re.compile(
        rf"[-+]?[1-9][0-9]{{0,2}}(?:([{other}{_BLANKS}])[0-9]{{3}}(?:\1[0-9]{{3}})*+(?:[{sign}][0-9]*)?"
        rf"|(?: [0-9]{{3}})++[{sign}][0-9]+)"
    )
    for sign, other in _SIGNS.items()
}
_CERTAIN = {  # numbers with thousands that cannot have another decimal sign
    sign: re.compile(
        rf"[-+]?[1-9][0-9]{{0,2}}(?:[{other}][0-9]{{3}})++[{sign}][0-9]*|[-+]?[1-9][0-9]{{0,2}}(?:[{other}][0-9]{{3}}){{2,}}"
    )
    for sign, other in _SIGNS.items()
}
_WITH_UNIT = re.compile(r"[-+]?(?!0x)[0-9][0-9.,e]*+\s*+[^\W\d_]|[-+]?[0-9][0-9.,]*+\s*+[%°]")
_DEEPEST = 40  # objects and lists of JSON in each other
_LONGEST_NAME = 1000  # characters of a column's name


class _Rows(NamedTuple):
    """The cells of rows that are needed: those of `Columns.fields` in this order, and that of the label."""

    cells: list[list[Any]]  # texts, or values of JSON
    lines: list[int]  # in the file, counted from 1
    lost: dict[int, str]  # lines that are no rows of the table, and why


def read_text_table(path: Path, columns: Columns) -> Table:
    """Reads a file of text: cells with separators between them, or objects of JSON.

    Raises:
        InputError: if it is not text, lacks a column, has two of one name, or no row of it holds numbers.
    """
    rows = _rows(path, columns)
    names = tuple(columns.fields)
    time = [str(row[0]) for row in rows.cells]
    clock = _clock(path, time, columns.time_unit) if is_clock(time) else None
    if clock is not None:
        for row, seconds in zip(rows.cells, clock.tolist(), strict=True):
            row[0] = seconds
    found = _in_numbers(path, rows, names, columns.text.decimal)
    lost = rows.lost | found.lost
    first = min(lost, default=None)
    every = len(lost) + len(found.good)
    if len(found.good) <= _LEAST_SHARE * every:
        expected = "is empty: it has no samples"
        if first is not None:
            read = f"{len(found.good)} of {every} rows are numbers for {', '.join(names[:6])}"
            expected = f"only {read}: row {first} {lost[first]}"
        raise InputError(path, "file", path.name, expected)
    if first is not None:
        note(LEFT_OUT, path, f"{len(lost)} of {every} rows", "", f"the first of them, row {first}, {lost[first]}")
    labels = () if columns.label is None else tuple(str(rows.cells[i][-1]) for i in found.good)
    return Table(path, names, found.values, np.array(rows.lines)[found.good], labels)


def _rows(path: Path, columns: Columns) -> _Rows:
    data = read_bytes(path)
    if form := foreign_binary(data):
        raise InputError(path, "file", path.name, form)
    text = decode(path, data, columns.text.encoding, "cp1252")
    whole = text.rstrip("\0")
    if len(whole) < len(text):
        note(LEFT_OUT, path, f"{len(text) - len(whole)} zeros at its end", "", "as a loss of power leaves them")
    if not whole.strip():
        raise InputError(path, "file", path.name, "is empty: it has no samples")
    lines = whole.split("\n")
    if re.match(r"\s*(\{|\[\s*\{)", whole):
        return _of_json(path, whole, lines, columns)
    return _of_cells(path, lines, columns)


def _of_cells(path: Path, lines: list[str], columns: Columns) -> _Rows:
    chosen = _SEPARATORS if columns.text.separator is None else (columns.text.separator,)
    if columns.header is None:
        separator, begin, names = _by_names(lines, set(columns.wanted), chosen)
        if (form := foreign_text(lines)) and not columns.wanted.keys() <= set(names):
            raise InputError(path, "file", path.name, form)
        before = begin - 1
    else:
        names = list(columns.header)
        separator, begin = _by_rows(lines, len(names), columns.places(path, names)[0], chosen)
        before = begin
    places = columns.places(path, names)
    rows = _Rows([], [], {})
    comments = 0
    for place, line in enumerate(lines[begin:], start=begin + 1):
        cells = _split(line, separator)
        while len(cells) > len(names) and not cells[-1]:
            cells.pop()
        if len(cells) == len(names) and any(cells):
            rows.cells.append([cells[i] for i in places])
            rows.lines.append(place)
        elif _COMMENT.match(line):
            comments += 1
        elif any(cells):
            rows.lost[place] = f"has {len(cells)} cells, and there are {len(names)} columns"
    if any(skipped := [line for line in lines[:before] if line.strip()]):
        note(LEFT_OUT, path, f"{len(skipped)} lines before the table", "", f"the first begins '{skipped[0][:30]}'")
    if comments:
        note(LEFT_OUT, path, f"{comments} lines", "", "they are comments")
    return rows


def _by_names(lines: list[str], wanted: set[str], separators: Sequence[str]) -> tuple[str, int, list[str]]:
    """The separator, the number of lines down to that of the names, and these; those that show most wanted names.

    Where none does, those with most words.
    """

    def split() -> Iterator[tuple[str, int, list[str]]]:
        for separator in separators:
            for i, line in enumerate(lines[:_HEAD]):
                yield separator, i + 1, _split(_uncommented(line), separator)
                if _COMMENT.match(line):  # the mark may belong to the first name, as in %time
                    yield separator, i + 1, _split(line, separator)

    best = max(split(), key=lambda each: len(wanted.intersection(each[2])))
    if wanted.isdisjoint(best[2]):
        best = max(split(), key=lambda each: sum(1 for name in each[2] if name and not _is_number(name)))
    return best


def _by_rows(lines: list[str], count: int, time: int, separators: Sequence[str]) -> tuple[str, int]:
    """The separator with which most lines have `count` cells, that at `time` a time; and the lines before the first."""

    def fitting(separator: str) -> list[int]:
        split = ((i, _split(line, separator)) for i, line in enumerate(lines[:_HEAD]))
        return [
            i
            for i, cells in split
            if len(cells) >= count
            and not any(cells[count:])
            and (is_clock([cells[time]]) or _is_number(cells[time]))
            and cells[time]
        ]

    found = {separator: fitting(separator) for separator in separators}
    separator = max(found, key=lambda each: (len(found[each]), len(_split(lines[-1] or lines[0], each))))
    return separator, found[separator][0] if found[separator] else 0


def _uncommented(line: str) -> str:
    mark = _COMMENT.match(line)
    return line[mark.end() :] if mark else line


def _split(line: str, separator: str) -> list[str]:
    if '"' in line and len(separator) == 1:
        with suppress(csv.Error):  # of a cell that is too long
            return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    return line.split() if separator == _SPACE else [cell.strip() for cell in line.split(separator)]


def _of_json(path: Path, text: str, lines: list[str], columns: Columns) -> _Rows:
    """Objects, one a line, or in a list; nested names are joined by dots, places in lists are in brackets."""
    wanted, names = columns.wanted, dict[str, None]()
    found: dict[int, dict[str, Any]] = {}
    lost: dict[int, str] = {}

    def add(place: int, value: Any) -> None:
        content = dict(_flat(value))
        names.update(dict.fromkeys(content))
        found[place] = {name: content[name] for name in wanted if name in content}

    with suppress(ValueError, TypeError):
        if text.lstrip().startswith("["):
            for i, value in enumerate(parse_json(path, text, finite=False), start=1):
                add(i, value)
    for i, line in enumerate([] if found else lines, start=1):
        try:
            if line.strip():
                add(i, parse_json(path, line, finite=False))
        except (ValueError, TypeError):
            lost[i] = "is not an object of JSON, or is nested too deeply"
    if not names:
        raise InputError(path, "file", path.name, "no line of it is a JSON object of numbers")
    columns.places(path, list(names))
    return _Rows([[content.get(name) for name in wanted] for content in found.values()], list(found), lost)


def _flat(value: Any) -> Iterator[tuple[str, Any]]:
    """The entries of an object, with their names.

    Raises:
        TypeError: if it is not an object.
        ValueError: if it is nested too deeply, or a name is too long.
    """
    if not isinstance(value, dict):
        raise TypeError("not an object")
    opened = [iter(value.items())]
    while opened:
        for name, entry in opened[-1]:
            if len(name) > _LONGEST_NAME or len(opened) > _DEEPEST:
                raise ValueError("nested too deeply, or too long a name")
            if isinstance(entry, dict):
                opened.append(iter([(f"{name}.{key}", part) for key, part in entry.items()]))
                break
            if isinstance(entry, list):
                opened.append(iter([(f"{name}[{i}]", part) for i, part in enumerate(entry)]))
                break
            if name:
                yield name, entry
        else:
            opened.pop()


class _Numbers(NamedTuple):
    values: Array  # (rows, columns)
    good: list[int]  # places of these rows among all
    lost: dict[int, str]  # lines of the others, and why


def _in_numbers(path: Path, rows: _Rows, names: Sequence[str], decimal: str | None) -> _Numbers:
    """The rows of numbers, with the decimal sign with which most are.

    Raises:
        InputError: if a sign in them may separate decimals or thousands.
    """
    cells = [cell for row in rows.cells for cell in row[: len(names)] if isinstance(cell, str)]
    commas = [cell for cell in cells if "," in cell]
    signs = (".", ",") if decimal is None and commas else (decimal or ".",)
    found = [_with_decimal(rows, names, sign) for sign in signs]
    best = max(range(len(signs)), key=lambda i: len(found[i].good))
    if decimal is None and commas:
        thousands = _SIGNS[signs[best]]
        grouped = [cell for cell in cells if thousands in cell and _THOUSANDS[signs[best]].fullmatch(cell)]
        if len(found[0].good) == len(found[1].good) > 0:
            _ask_for_decimal(path, commas[0])
        if grouped and not any(_CERTAIN[signs[best]].fullmatch(cell) for cell in grouped):
            _ask_for_decimal(path, grouped[0])
    return found[best]


def _ask_for_decimal(path: Path, cell: str) -> NoReturn:
    expected = 'does its point or comma separate decimals or thousands? say so: text: { decimal: "," }, or "."'
    raise InputError(path, "text.decimal", cell, expected)


def _with_decimal(rows: _Rows, names: Sequence[str], decimal: str) -> _Numbers:
    values, good, lost = [], [], {}
    for i, row in enumerate(rows.cells):
        cells = row[: len(names)]
        try:
            values.append([_number(cell, decimal) for cell in cells])
            good.append(i)
        except ValueError:
            wrong = next(place for place, cell in enumerate(cells) if not _is_number(cell, decimal))
            lost[rows.lines[i]] = f"has '{str(row[wrong])[:30]}' for {names[wrong]}, {_mend(row[wrong])}"
    return _Numbers(np.array(values, dtype=float).reshape(len(good), len(names)), good, lost)


def _number(cell: Any, decimal: str = ".") -> float:
    """A cell as a number; NaN if it is empty. Square brackets, as around lists, are ignored.

    Raises:
        ValueError: if it is not a number.
    """
    if not isinstance(cell, str):
        try:
            return math.nan if cell is None else float(cell)
        except OverflowError:  # of a whole number with hundreds of digits
            return math.inf
    if decimal == "." and is_number(cell):
        return float(cell)
    text = cell.strip("[] \xa0").replace("\u2212", "-")
    if text.lower() in _MISSING:
        return math.nan
    if text.lower().lstrip("+-") in _INFINITE:
        return -math.inf if text.startswith("-") else math.inf
    if _THOUSANDS[decimal].fullmatch(text):
        text = text.translate(dict.fromkeys(map(ord, f"{_SIGNS[decimal]}{_BLANKS} ")))
    elif _SIGNS[decimal] in text:
        raise ValueError(text)
    return number(text.replace(decimal, "."))


def _mend(cell: Any) -> str:
    """Why a cell is not a number, and what would make it one."""
    text = str(cell).strip("[] \xa0")
    if re.fullmatch(r"[-+]?[1-9][0-9]{0,2}(?: [0-9]{3})+", text):
        return "which is one number or several: leave out the spaces between its digits"
    if _WITH_UNIT.match(text):
        return "which is not a number: leave units out of the cells, `unit` in the description states them"
    return "which is not a number"


def _is_number(cell: Any, decimal: str = ".") -> bool:
    try:
        _number(cell, decimal)
    except ValueError:
        return False
    return True


def _clock(path: Path, cells: Sequence[str], unit: float) -> Array:
    """Times since the first, in units of `unit` s."""
    seconds, midnights = seconds_of(cells)
    if midnights:
        note(MENDED, path, "the time", "", "it passes midnight: a day is added from there on")
    return seconds / unit
