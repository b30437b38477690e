"""Reads text of loggers, spreadsheets and scripts: a file and the names of its columns -> a `Table`.

The form of a file is inferred from the names of its columns: the separator and the line of names
are those that show most of them, and the decimal sign is the one with which most rows are numbers. Lines that are no
rows of numbers are left out with a note. Columns that are not needed are ignored.
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
from soft_gripper.extras.hardware.clock_times import elapsed_seconds, is_clock
from soft_gripper.extras.hardware.foreign_files import foreign_binary, foreign_text
from soft_gripper.extras.hardware.table import Columns, Table
from soft_gripper.files.json_text import parse_json
from soft_gripper.files.notes import LEFT_OUT, MENDED, note
from soft_gripper.files.number import is_number, number
from soft_gripper.files.text import decode, read_bytes

_SPACES = " "  # any number of spaces and tabs
_SEPARATORS = "\t", ";", ",", "|", _SPACES
_COMMENT_PATTERN = re.compile(r"\s*+(?:#|%|//)++ *+")
_MAX_HEAD_LINES = 1000  # lines in which the names of columns are looked for
_MIN_NUMBER_SHARE = 0.05  # of rows that are numbers; with fewer, the form of the file was not recognised
_MISSING_TEXTS = frozenset(
    (
        *("", "na", "n/a", "#n/a", "null", "none", "-", "--", "---", "?", "#div/0!", "#value!"),
        *("nan", "+nan", "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"),
    )
)
_INFINITE_TEXTS = frozenset(("inf", "infinity"))  # refused by the table, with its row
_THOUSANDS_SIGNS = {".": ",", ",": "."}  # a decimal sign, and what may separate thousands beside it
_BLANKS = "'\u2019\xa0\u2007\u2009\u202f"  # what separates nothing else: apostrophes, and spaces that do not break
_THOUSANDS_PATTERNS = {  # a common space can also lie between two numbers, unless a decimal sign follows
    sign: re.compile(
        rf"[-+]?[1-9][0-9]{{0,2}}(?:([{other}{_BLANKS}])[0-9]{{3}}(?:\1[0-9]{{3}})*+(?:[{sign}][0-9]*)?"
        rf"|(?: [0-9]{{3}})++[{sign}][0-9]+)"
    )
    for sign, other in _THOUSANDS_SIGNS.items()
}
_UNAMBIGUOUS_PATTERNS = {  # numbers with thousands that cannot have another decimal sign
    sign: re.compile(
        rf"[-+]?[1-9][0-9]{{0,2}}(?:[{other}][0-9]{{3}})++[{sign}][0-9]*|[-+]?[1-9][0-9]{{0,2}}(?:[{other}][0-9]{{3}}){{2,}}"
    )
    for sign, other in _THOUSANDS_SIGNS.items()
}
_UNIT_PATTERN = re.compile(r"[-+]?(?!0x)[0-9][0-9.,e]*+\s*+[^\W\d_]|[-+]?[0-9][0-9.,]*+\s*+[%°]")
_MAX_DEPTH = 40  # objects and lists of JSON in each other
_MAX_NAME_LENGTH = 1000  # characters of a column's name


class _Rows(NamedTuple):
    """Cells of the needed columns of rows: those of `Columns.fields` in this order, then the label."""

    cells: list[list[Any]]  # texts, or values of JSON
    lines: list[int]  # in the file, counted from 1
    lost: dict[int, str]  # lines that are no rows of the table, and why


def read_text_table(path: Path, columns: Columns) -> Table:
    """Reads a file of text: cells with separators between them, or objects of JSON."""
    rows = _read_rows(path, columns)
    names = tuple(columns.fields)
    time = [str(row[0]) for row in rows.cells]
    clock = _clock_seconds(path, time, columns.time_unit) if is_clock(time) else None
    if clock is not None:
        for row, seconds in zip(rows.cells, clock.tolist(), strict=True):
            row[0] = seconds
    numbers = _parse_numbers(path, rows, names, columns.text.decimal)
    lost = rows.lost | numbers.lost
    first = min(lost, default=None)
    row_count = len(lost) + len(numbers.good)
    if len(numbers.good) <= _MIN_NUMBER_SHARE * row_count:
        expected = "is empty: it has no samples"
        if first is not None:
            count_text = f"{len(numbers.good)} of {row_count} rows are numbers for {', '.join(names[:6])}"
            expected = f"only {count_text}: row {first} {lost[first]}"
        raise InputError(path, "file", path.name, expected)
    if first is not None:
        note(LEFT_OUT, path, f"{len(lost)} of {row_count} rows", "", f"the first of them, row {first}, {lost[first]}")
    labels = () if columns.label is None else tuple(str(rows.cells[i][-1]) for i in numbers.good)
    return Table(path, names, numbers.values, np.array(rows.lines)[numbers.good], labels)


def _read_rows(path: Path, columns: Columns) -> _Rows:
    data = read_bytes(path)
    if advice := foreign_binary(data):
        raise InputError(path, "file", path.name, advice)
    text = decode(path, data, columns.text.encoding, "cp1252")
    content = text.rstrip("\0")
    if len(content) < len(text):
        note(LEFT_OUT, path, f"{len(text) - len(content)} zeros at its end", "", "as a loss of power leaves them")
    if not content.strip():
        raise InputError(path, "file", path.name, "is empty: it has no samples")
    lines = content.split("\n")
    if re.match(r"\s*(\{|\[\s*\{)", content):
        return _json_rows(path, content, lines, columns)
    return _cell_rows(path, lines, columns)


def _cell_rows(path: Path, lines: list[str], columns: Columns) -> _Rows:
    separators = _SEPARATORS if columns.text.separator is None else (columns.text.separator,)
    if columns.header is None:
        separator, begin, names = _named_separator(lines, set(columns.all_fields), separators)
        if (form := foreign_text(lines)) and not columns.all_fields.keys() <= set(names):
            raise InputError(path, "file", path.name, form)
        head_lines = begin - 1
    else:
        names = list(columns.header)
        separator, begin = _counted_separator(lines, len(names), columns.places(path, names)[0], separators)
        head_lines = begin
    places = columns.places(path, names)
    rows = _Rows([], [], {})
    comments = 0
    for line_number, line in enumerate(lines[begin:], start=begin + 1):
        cells = _split(line, separator)
        while len(cells) > len(names) and not cells[-1]:
            cells.pop()
        if len(cells) == len(names) and any(cells):
            rows.cells.append([cells[i] for i in places])
            rows.lines.append(line_number)
        elif _COMMENT_PATTERN.match(line):
            comments += 1
        elif any(cells):
            rows.lost[line_number] = f"has {len(cells)} cells, and there are {len(names)} columns"
    if any(skipped := [line for line in lines[:head_lines] if line.strip()]):
        note(LEFT_OUT, path, f"{len(skipped)} lines before the table", "", f"the first begins '{skipped[0][:30]}'")
    if comments:
        note(LEFT_OUT, path, f"{comments} lines", "", "they are comments")
    return rows


def _named_separator(lines: list[str], names: set[str], separators: Sequence[str]) -> tuple[str, int, list[str]]:
    """Separator, number of lines up to the names, and the names, chosen to find most needed names.

    If none does, those with most words.
    """

    def split() -> Iterator[tuple[str, int, list[str]]]:
        for separator in separators:
            for i, line in enumerate(lines[:_MAX_HEAD_LINES]):
                yield separator, i + 1, _split(_strip_comment(line), separator)
                if _COMMENT_PATTERN.match(line):  # the mark may belong to the first name, as in %time
                    yield separator, i + 1, _split(line, separator)

    best = max(split(), key=lambda head: len(names.intersection(head[2])))
    if names.isdisjoint(best[2]):
        best = max(split(), key=lambda head: sum(1 for name in head[2] if name and not _is_number(name)))
    return best


def _counted_separator(lines: list[str], count: int, time: int, separators: Sequence[str]) -> tuple[str, int]:
    """Separator with which most lines have `count` cells, that at `time` a time; and the lines before the first."""

    def fitting_lines(separator: str) -> list[int]:
        split_lines = ((i, _split(line, separator)) for i, line in enumerate(lines[:_MAX_HEAD_LINES]))
        return [
            i
            for i, cells in split_lines
            if len(cells) >= count
            and not any(cells[count:])
            and (is_clock([cells[time]]) or _is_number(cells[time]))
            and cells[time]
        ]

    rows = {separator: fitting_lines(separator) for separator in separators}
    separator = max(separators, key=lambda sign: (len(rows[sign]), len(_split(lines[-1] or lines[0], sign))))
    return separator, rows[separator][0] if rows[separator] else 0


def _strip_comment(line: str) -> str:
    comment = _COMMENT_PATTERN.match(line)
    return line[comment.end() :] if comment else line


def _split(line: str, separator: str) -> list[str]:
    if '"' in line and len(separator) == 1:
        with suppress(csv.Error):  # of a cell that is too long
            return [cell.strip() for cell in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    return line.split() if separator == _SPACES else [cell.strip() for cell in line.split(separator)]


def _json_rows(path: Path, text: str, lines: list[str], columns: Columns) -> _Rows:
    """Objects, one a line, or in a list; nested names are joined by dots, places in lists are in brackets."""
    all_fields, names = columns.all_fields, dict[str, None]()
    objects: dict[int, dict[str, Any]] = {}
    lost: dict[int, str] = {}

    def add(line_number: int, value: Any) -> None:
        content = dict(_flatten(value))
        names.update(dict.fromkeys(content))
        objects[line_number] = {name: content[name] for name in all_fields if name in content}

    with suppress(ValueError, TypeError):
        if text.lstrip().startswith("["):
            for i, value in enumerate(parse_json(path, text, finite=False), start=1):
                add(i, value)
    for i, line in enumerate([] if objects else lines, start=1):
        try:
            if line.strip():
                add(i, parse_json(path, line, finite=False))
        except (ValueError, TypeError):
            lost[i] = "is not an object of JSON, or is nested too deeply"
    if not names:
        raise InputError(path, "file", path.name, "no line of it is a JSON object of numbers")
    columns.places(path, list(names))
    return _Rows([[content.get(name) for name in all_fields] for content in objects.values()], list(objects), lost)


def _flatten(value: Any) -> Iterator[tuple[str, Any]]:
    """Yields the entries of an object with their names.

    Raises:
        TypeError: if it is not an object.
        ValueError: if it is nested too deeply, or a name is too long.
    """
    if not isinstance(value, dict):
        raise TypeError("not an object")
    open_items = [iter(value.items())]
    while open_items:
        for name, entry in open_items[-1]:
            if len(name) > _MAX_NAME_LENGTH or len(open_items) > _MAX_DEPTH:
                raise ValueError("nested too deeply, or too long a name")
            if isinstance(entry, dict):
                open_items.append(iter([(f"{name}.{key}", entry_value) for key, entry_value in entry.items()]))
                break
            if isinstance(entry, list):
                open_items.append(iter([(f"{name}[{i}]", entry_value) for i, entry_value in enumerate(entry)]))
                break
            if name:
                yield name, entry
        else:
            open_items.pop()


class _Numbers(NamedTuple):
    values: Array  # (rows, columns)
    good: list[int]  # indices of these rows among all
    lost: dict[int, str]  # lines of the others, and why


def _parse_numbers(path: Path, rows: _Rows, names: Sequence[str], decimal: str | None) -> _Numbers:
    """Parses rows of numbers with the decimal sign with which most are numbers."""
    cells = [cell for row in rows.cells for cell in row[: len(names)] if isinstance(cell, str)]
    comma_cells = [cell for cell in cells if "," in cell]
    signs = (".", ",") if decimal is None and comma_cells else (decimal or ".",)
    numbers = [_parse_rows(rows, names, sign) for sign in signs]
    index = max(range(len(signs)), key=lambda i: len(numbers[i].good))
    if decimal is None and comma_cells:
        thousands = _THOUSANDS_SIGNS[signs[index]]
        groups = [cell for cell in cells if thousands in cell and _THOUSANDS_PATTERNS[signs[index]].fullmatch(cell)]
        if len(numbers[0].good) == len(numbers[1].good) > 0:
            _refuse_decimal(path, comma_cells[0])
        if groups and not any(_UNAMBIGUOUS_PATTERNS[signs[index]].fullmatch(cell) for cell in groups):
            _refuse_decimal(path, groups[0])
    return numbers[index]


def _refuse_decimal(path: Path, cell: str) -> NoReturn:
    expected = 'does its point or comma separate decimals or thousands? say so: text: { decimal: "," }, or "."'
    raise InputError(path, "text.decimal", cell, expected)


def _parse_rows(rows: _Rows, names: Sequence[str], decimal: str) -> _Numbers:
    values, good_rows, reasons = [], [], {}
    for i, row in enumerate(rows.cells):
        cells = row[: len(names)]
        try:
            values.append([_number(cell, decimal) for cell in cells])
            good_rows.append(i)
        except ValueError:
            column = next(place for place, cell in enumerate(cells) if not _is_number(cell, decimal))
            reasons[rows.lines[i]] = f"has '{str(row[column])[:30]}' for {names[column]}, {_number_advice(row[column])}"
    return _Numbers(np.array(values, dtype=float).reshape(len(good_rows), len(names)), good_rows, reasons)


def _number(cell: Any, decimal: str = ".") -> float:
    """Number in a cell; NaN if it is empty. Square brackets, as around lists, are ignored.

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
    if text.lower() in _MISSING_TEXTS:
        return math.nan
    if text.lower().lstrip("+-") in _INFINITE_TEXTS:
        return -math.inf if text.startswith("-") else math.inf
    if _THOUSANDS_PATTERNS[decimal].fullmatch(text):
        text = text.translate(dict.fromkeys(map(ord, f"{_THOUSANDS_SIGNS[decimal]}{_BLANKS} ")))
    elif _THOUSANDS_SIGNS[decimal] in text:
        raise ValueError(text)
    return number(text.replace(decimal, "."))


def _number_advice(cell: Any) -> str:
    """Text that says why a cell is not a number, with a remedy."""
    text = str(cell).strip("[] \xa0")
    if re.fullmatch(r"[-+]?[1-9][0-9]{0,2}(?: [0-9]{3})+", text):
        return "which is one number or several: leave out the spaces between its digits"
    if _UNIT_PATTERN.match(text):
        return "which is not a number: leave units out of the cells, `unit` in the description states them"
    return "which is not a number"


def _is_number(cell: Any, decimal: str = ".") -> bool:
    try:
        _number(cell, decimal)
    except ValueError:
        return False
    return True


def _clock_seconds(path: Path, cells: Sequence[str], unit: float) -> Array:
    """Times since the first, in units of `unit` s."""
    seconds, midnights = elapsed_seconds(cells)
    if midnights:
        note(MENDED, path, "the time", "", "it passes midnight: a day is added from there on")
    return seconds / unit
