"""The rows of a table that was written."""

import csv
from pathlib import Path


def csv_rows(file: Path) -> list[dict[str, str]]:
    """Rows by the names of their columns, as text."""
    with file.open(newline="", encoding="utf-8") as text:
        return list(csv.DictReader(text))
