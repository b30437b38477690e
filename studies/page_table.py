"""Tables of pages that a study writes."""

from collections.abc import Sequence
from pathlib import Path


def write_table(page: Path, table: Sequence[str]) -> None:
    """Puts a table, lines of Markdown, in the place of the one that a page has under its heading."""
    lines = page.read_text(encoding="utf-8").splitlines()
    start = lines.index(table[0])
    end = next(number for number in range(start, len(lines)) if not lines[number].startswith("|"))
    lines[start:end] = table
    page.write_text("\n".join(lines) + "\n", encoding="utf-8")
