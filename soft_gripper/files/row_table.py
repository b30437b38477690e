"""Tables of dataclass rows: CSV files, and text for people.

The name of a field ends in its unit, and its type has the format in which it is printed:

    @dataclass(frozen=True)
    class Row:
        finger: str
        tip_error_mm: Annotated[float, ".2f"]

A CSV file has the column `tip_error_mm`, and a terminal the column "tip error [mm]", with two decimals.
"""

import csv
import itertools
import math
import textwrap
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import astuple, fields
from io import StringIO
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_args, get_origin, get_type_hints

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import MAX_BYTES, read_text

Row = TypeVar("Row")
WIDTH = 100  # of a printed table
_COLUMN_GAP = 2
UNKNOWN = "not known"  # in sentences, in the place of nan
_UNITS = {"deg": "degrees", "g": "g", "kpa": "kPa", "mj": "mJ", "mm": "mm", "mm2": "mm^2", "mnm": "mN m", "mns": "mN s"}
_UNITS |= {"ms": "ms", "n": "N", "percent": "%", "s": "s"}


def write_csv(path: Path, rows: Sequence[Any]) -> None:
    write_rows(path, columns(type(rows[0])), map(cells, rows))


def write_rows(path: Path, names: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    with atomic_file(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(rows)


def read_csv(path: Path, row: type[Row]) -> list[Row]:
    """Reads a file of `write_csv`, as rows of type `row`; raises an InputError if it has none, or anything else."""
    names = columns(row)
    try:
        records = list(csv.DictReader(StringIO(read_text(path, MAX_BYTES))))
        rows = [row_from_cells([record[name] for name in names], row) for record in records]
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(path, "file", path.name, f"is not a table as it was written: {error!r}") from None
    if not rows:
        raise InputError(path, "file", path.name, "holds no rows")
    return rows


def columns(row: type[Any]) -> list[str]:
    return [field.name for field in fields(row)]


def cells(row: Any) -> list[str]:
    # Adding zero turns -0.0 into 0.0.
    return [f"{round(x, 6) + 0.0:.6f}" if isinstance(x, float) else str(x) for x in astuple(row)]


def row_from_cells(texts: Sequence[str], row: type[Row]) -> Row:
    """The row with these cells; raises a ValueError if they do not fit."""
    kinds, cells_by_name = get_type_hints(row), zip(texts, columns(row), strict=True)
    return row(*(text == "True" if kinds[name] is bool else kinds[name](text) for text, name in cells_by_name))


def print_table(columns: Mapping[str, str], rows: Iterable[Sequence[Any]], title: str = "") -> None:
    """Prints a table, see `table_text`, below an empty line; `columns` are the formats by heading."""
    print(f"\n{table_text(list(columns), list(columns.values()), rows, title)}")


def table_text(headings: Sequence[str], forms: Sequence[str], rows: Iterable[Sequence[Any]], title: str = "") -> str:
    """Rows of cells below their headings, in WIDTH columns of text; units have a separate line.

    If it is wider, headings are in several lines; if it still is, further columns are below, beside the names again.

    Args:
        headings: of the columns; a unit is in brackets at the end.
        forms: format specification of each column; "": text, aligned left.
        rows: cells in the order of the columns; NaN is a dash. Columns of nothing else are left out.
        title: a line above the table.
    """
    records = [*map(list, rows)]
    columns = []
    for i, (heading, format_spec) in enumerate(zip(headings, forms, strict=True)):
        if not records or not all(_is_nan(record[i]) for record in records):
            columns.append(_Column(heading, format_spec, [_cell_text(record[i], format_spec) for record in records]))
    if _width(columns) > WIDTH:
        columns = [column.narrow() for column in columns]
    blocks = ["\n".join(_lines(block)) for block in _blocks(columns)]
    return "\n".join([*([title] if title else []), "\n\n".join(blocks)])


class _Column:
    """A column of text: the lines of its heading, its unit, and its cells."""

    def __init__(self, heading: str, form: str, cells: list[str]):
        words, _, unit = heading.partition(" [")
        self.heading, self.unit, self.cells = [words], f"[{unit}" if unit else "", cells
        self.side = ">" if form else "<"

    @property
    def width(self) -> int:
        return max(map(len, (*self.heading, self.unit, *self.cells)))

    def narrow(self) -> "_Column":
        """The column with its heading in as many lines as it takes to be no wider than its cells and its words."""
        longest = max(map(len, (*self.heading[0].split(), self.unit, *self.cells, "-")))
        self.heading = textwrap.wrap(self.heading[0], longest) or [""]
        return self


def _width(columns: Sequence[_Column]) -> int:
    return sum(column.width + _COLUMN_GAP for column in columns) - _COLUMN_GAP


def _blocks(columns: Sequence[_Column]) -> list[list[_Column]]:
    """Blocks of columns that fit WIDTH; each begins with the leading text columns of the table."""
    names = [*itertools.takewhile(lambda column: column.side == "<", columns)]
    blocks, rest = [[*names]], columns[len(names) :]
    for column in rest:
        if len(blocks[-1]) > len(names) and _width([*blocks[-1], column]) > WIDTH:
            blocks.append([*names])
        blocks[-1].append(column)
    return blocks


def _lines(columns: Sequence[_Column]) -> list[str]:
    heights = max(len(column.heading) for column in columns)
    parts = [[*[""] * (heights - len(column.heading)), *column.heading] for column in columns]
    if any(column.unit for column in columns):
        parts = [[*part, column.unit] for part, column in zip(parts, columns, strict=True)]
    texts = [[*part, *column.cells] for part, column in zip(parts, columns, strict=True)]
    forms = [f"{column.side}{column.width}" for column in columns]
    lines = (map(format, line, forms) for line in zip(*texts, strict=True))
    return ["  ".join(line).rstrip() for line in lines]


def _is_nan(cell: Any) -> bool:
    return isinstance(cell, float) and math.isnan(cell)


def _cell_text(cell: Any, form: str) -> str:
    """A cell as it is printed; zero has no sign."""
    if _is_nan(cell):
        return "-"
    text = format(cell, form)
    return text if not form or text.strip("-0.") else text.lstrip("-")


def print_rows(rows: Sequence[Any], title: str = "", leave: Collection[str] = ()) -> None:
    """Prints rows of one dataclass under the headings of its fields, without the fields `leave`."""
    kind = type(rows[0])
    names = [name for name in columns(kind) if name not in leave]
    print_table(headings(kind, names), ([getattr(row, name) for name in names] for row in rows), title)


def headings(row: type[Any], names: Sequence[str]) -> dict[str, str]:
    """The format of each of these fields of a row, by its heading, for `print_table`."""
    kinds, formats = get_type_hints(row, include_extras=True), {}
    for name in names:
        words, _, unit = name.rpartition("_")
        heading = f"{words} [{_UNITS[unit]}]" if words and unit in _UNITS else name
        is_annotated = get_origin(kinds[name]) is Annotated
        format_spec = str(get_args(kinds[name])[1]) if is_annotated else {int: "d", float: "g"}.get(kinds[name], "")
        formats[heading.replace("_", " ")] = format_spec
    return formats
