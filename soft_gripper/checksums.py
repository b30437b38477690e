"""Checksums of the files in a folder, in the form of sha256sum: whether results are all there, and as they were."""

import hashlib
from pathlib import Path

SUMS = "SHA256SUMS"


def write_checksums(folder: Path) -> None:
    """Writes the checksums of all files below a folder; `sha256sum -c SHA256SUMS` checks them too."""
    (folder / SUMS).write_text(_checksums(folder), encoding="utf-8")


def is_whole(folder: Path) -> bool:
    """Whether all files are in a folder that `write_checksums` saw there, and none of them has changed."""
    try:
        written = (folder / SUMS).read_text(encoding="utf-8").splitlines()
        return bool(written) and set(written) <= set(_checksums(folder).splitlines())
    except (OSError, UnicodeError):
        return False


def _checksums(folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != SUMS)
    return "".join(f"{_digest(path)}  {path.relative_to(folder).as_posix()}\n" for path in files)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
