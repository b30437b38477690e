"""Tables of dataclass rows as CSV files."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import astuple, fields
from io import StringIO
from pathlib import Path
from typing import Any, TypeVar

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text

Row = TypeVar("Row")


def write_csv(path: Path, rows: Sequence[Any]) -> None:
    """Writes rows of one dataclass under the names of its fields."""
    write_rows(path, columns(type(rows[0])), map(cells, rows))


def write_rows(path: Path, names: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Writes rows of cells under the names of their columns."""
    with atomic_file(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(rows)


def read_csv(path: Path, row: type[Row]) -> list[Row]:
    """Reads what `write_csv` wrote from rows of type `row`, whose fields are str, bool, int or float.

    Raises:
        InputError: if the file is missing, has no rows, or contains anything else.
    """
    names = columns(row)
    try:
        records = list(csv.DictReader(StringIO(read_text(path))))
        rows = [of_cells([record[name] for name in names], row) for record in records]
    except (KeyError, TypeError, ValueError, csv.Error) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(path, "file", path.name, f"is not a table as it was written: {error!r}") from None
    if not rows:
        raise InputError(path, "file", path.name, "holds no rows")
    return rows


def columns(row: type[Any]) -> list[str]:
    """The names of the columns of a table of such rows."""
    return [field.name for field in fields(row)]


def cells(row: Any) -> list[str]:
    """The cells of a row as `write_csv` writes them."""
    return [_text(value) for value in astuple(row)]


def of_cells(texts: Sequence[str], row: type[Row]) -> Row:
    """The row with these cells; raises a ValueError if they do not fit."""
    kinds = [field.type for field in fields(row)]  # type: ignore[arg-type]
    return row(*(_value(text, kind) for text, kind in zip(texts, kinds, strict=True)))


def _value(text: str, kind: Any) -> Any:
    return text == "True" if kind is bool else kind(text)


def _text(value: object) -> str:
    # Adding zero turns -0.0 into 0.0.
    return f"{round(value, 6) + 0.0:.6f}" if isinstance(value, float) else str(value)
