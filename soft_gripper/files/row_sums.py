"""Checksums of the rows of a table that is resumed: a row that was changed since is not believed, and run again."""

import hashlib
import logging
from collections.abc import Iterable
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text

_LOGGER = logging.getLogger(__name__)


def sums_file(table: Path) -> Path:
    """Where the checksums of a table are."""
    return table.with_name(f"{table.name}.sha256")


def row_sum(cells: Iterable[str]) -> str:
    """The checksum of the cells of a row."""
    return hashlib.sha256("\0".join(cells).encode("utf-8", "surrogateescape")).hexdigest()


def write_sums(table: Path, sums: Iterable[str]) -> None:
    """Writes the checksums of all rows of a table, a line for each.

    Raises:
        InputError: if they cannot be written.
    """
    with atomic_file(sums_file(table)) as partial:
        partial.write_text("".join(f"{each}\n" for each in sums), encoding="ascii")


def read_sums(table: Path) -> set[str]:
    """The checksums of the rows of a table that were written; none if there is no such file."""
    try:
        return set(read_text(sums_file(table)).split())
    except InputError:
        return set()


def note_changed(table: Path, number: int) -> None:
    """Says that rows of a table are not believed."""
    if number:
        _LOGGER.warning("%s: %d rows are not whole or were changed; they are run again", table, number)
