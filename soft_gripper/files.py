"""Files that are written whole or not at all, and where they may be written."""

import os
import shutil
import stat
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from soft_gripper.checksums import write_checksums
from soft_gripper.errors import InputError


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """A name to write to; when the block ends without an error, what was written takes the place of `path`.

    A symlink is followed. What is no regular file, such as a named pipe, stays and is written to.
    """
    _require_name(path)
    target = Path(os.path.realpath(path))
    try:
        with (_written_through if _is_special(target) else _replaced)(target, path.name) as partial:
            yield partial
    except OSError as error:
        raise InputError("output", "file", str(path), f"cannot be written: {error.strerror or error}") from None


@contextmanager
def _replaced(target: Path, name: str) -> Iterator[Path]:
    partial = target.with_name(f".{os.getpid()}-{name}")
    try:
        yield partial
        os.replace(partial, target)
    finally:
        with suppress(OSError):
            partial.unlink()


@contextmanager
def _written_through(target: Path, name: str) -> Iterator[Path]:
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        partial = Path(folder) / name
        yield partial
        with partial.open("rb") as written, os.fdopen(os.open(target, os.O_WRONLY), "wb") as file:
            shutil.copyfileobj(written, file)


def _is_special(path: Path) -> bool:
    """Whether there is something that is no regular file; a folder is not meant."""
    try:
        return not stat.S_ISREG(path.stat().st_mode)
    except FileNotFoundError:
        return False


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """A folder beside `folder` to fill; it takes the place of `folder` when the block ends without an error.

    It then holds the checksums of its files, by which `is_whole` knows it.
    """
    remove_partial(folder)
    partial = _partial(folder)
    partial.mkdir(parents=True)
    try:
        yield partial
        write_checksums(partial)
        shutil.rmtree(folder, ignore_errors=True)
        partial.rename(folder)
    finally:
        remove_partial(folder)


def read_folder(folder: Path) -> dict[str, bytes]:
    """The files of a folder by their names."""
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def write_folder(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes what `read_folder` gave, whole.

    Raises:
        InputError: if it cannot be written.
    """
    try:
        with atomic_folder(folder) as partial:
            for name, content in files.items():
                (partial / name).write_bytes(content)
    except OSError as error:
        raise InputError("output", "folder", str(folder), f"cannot be written: {_reason(error)}") from None


def remove_partial(folder: Path) -> None:
    """Removes what a killed process left of filling `folder`."""
    shutil.rmtree(_partial(folder), ignore_errors=True)


def _partial(folder: Path) -> Path:
    return folder.with_name(f".partial-{folder.name}")


def writable_folder(path: Path) -> Path:
    """Makes a folder for output, or says before any work is done that it cannot be written to.

    Raises:
        InputError: if the folder cannot be made or written to.
    """
    _try_writing("folder", path, path, "probe")
    _remove_left_over(path)
    return path


def _remove_left_over(folder: Path) -> None:
    """Removes what processes that were killed left of writing files, see `atomic_file`."""
    for file in folder.glob(".*-*"):
        pid = file.name[1:].partition("-")[0]
        if pid.isdecimal() and not _is_alive(int(pid)):
            file.unlink(missing_ok=True)


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, OverflowError):
        return False
    except PermissionError:
        pass
    return True


def check_file(path: Path) -> None:
    """Says before any work is done whether a file of this name can be written; makes the folder for it.

    Raises:
        InputError: if it cannot.
    """
    _require_name(path)
    try:
        target = Path(os.path.realpath(path))
        special = _is_special(target)
    except (OSError, ValueError) as error:
        raise InputError("output", "file", str(path), f"cannot be written: {_reason(error)}") from None
    if not special:
        _try_writing("file", path, target.parent, path.name)


def _require_name(path: Path) -> None:
    if not path.name or os.path.isdir(path):
        raise InputError("output", "file", str(path), "cannot be written: it is a folder; name a file")


def _try_writing(field: str, asked: Path, folder: Path, name: str) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / f".{os.getpid()}-{name}"
        probe.touch()
        probe.unlink()
    except (OSError, ValueError) as error:
        raise InputError("output", field, str(asked), f"cannot be written to: {_reason(error)}") from None


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
