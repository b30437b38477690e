"""Tables of dataclass rows as CSV files."""

import csv
from collections.abc import Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Any, TypeVar

from soft_gripper.files import atomic_file

Row = TypeVar("Row")


def write_csv(path: Path, rows: Sequence[Any]) -> None:
    """Writes rows of one dataclass under the names of its fields."""
    with atomic_file(path) as partial, partial.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in fields(rows[0]))
        writer.writerows([_text(value) for value in astuple(row)] for row in rows)


def read_csv(path: Path, row: type[Row]) -> list[Row]:
    """Reads what `write_csv` wrote from rows of type `row`, whose fields are str, bool, int or float."""
    with path.open(newline="") as file:
        records = list(csv.DictReader(file))
    columns = {field.name: field.type for field in fields(row)}  # type: ignore[arg-type]
    return [row(**{name: _value(record[name], kind) for name, kind in columns.items()}) for record in records]


def _value(text: str, kind: Any) -> Any:
    return text == "True" if kind is bool else kind(text)


def _text(value: object) -> str:
    # Adding zero turns -0.0 into 0.0.
    return f"{round(value, 6) + 0.0:.6f}" if isinstance(value, float) else str(value)
