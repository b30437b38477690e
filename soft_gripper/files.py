"""Files that are written whole or not at all."""

import fcntl
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from soft_gripper.errors import InputError


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """A name beside `path` to write to; it takes the place of `path` when the block ends without an error."""
    partial = path.with_name(f".{os.getpid()}-{path.name}")
    try:
        yield partial
        os.replace(partial, path)
    except OSError as error:
        raise _cannot_be_written(path, error) from None
    finally:
        with suppress(OSError):
            partial.unlink()


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """A folder beside `folder` to fill; it takes the place of `folder` when the block ends without an error."""
    partial = _partial(folder)
    shutil.rmtree(partial, ignore_errors=True)  # what a killed process left
    partial.mkdir(parents=True)
    try:
        yield partial
        shutil.rmtree(folder, ignore_errors=True)
        partial.rename(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


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
        raise _cannot_be_written(folder, error) from None


def _cannot_be_written(path: Path, error: OSError) -> InputError:
    return InputError("output", "file", str(path), f"cannot be written: {error.strerror or error}")


def _partial(folder: Path) -> Path:
    return folder.with_name(f".partial-{folder.name}")


def writable_folder(path: Path) -> Path:
    """Makes a folder for output, or says before any work is done that it cannot be written to.

    Raises:
        InputError: if the folder cannot be made or written to.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        _remove_left_over(path)
        probe = path / f".{os.getpid()}-probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise InputError("output", "folder", str(path), f"cannot be written to: {error.strerror}") from None
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


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Keeps a folder for this process, which lets go of it however it ends.

    Raises:
        InputError: if another one keeps it.
    """
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise InputError("output", "folder", str(folder), "another run is writing to it") from None
    finally:
        os.close(descriptor)
