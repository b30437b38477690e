"""Writes the tables of a study into pages of the documentation."""

from collections.abc import Sequence
from pathlib import Path


def write_table(page: Path, table: Sequence[str]) -> None:
    """Replaces a table of a page, lines of Markdown, by one with the same heading."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = lines.index(table[0])
    end = next(number for number in range(start, len(lines)) if not lines[number].startswith("|"))
    lines[start:end] = table
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")
