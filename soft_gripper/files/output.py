"""Files that are written whole or not at all, and where they may be written.

A folder of results appears at once, with its checksums (SHA256SUMS). Resuming trusts these, not a scenario file that
may lie next to incomplete results.
"""

import errno
import fcntl
import hashlib
import itertools
import os
import re
import shutil
import stat
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from soft_gripper.errors import InputError
from soft_gripper.files.text import read_text

SUMS = "SHA256SUMS"
_TEMP_PREFIX = ".soft-gripper-"  # of what is incomplete; host and process follow, so that no other's files are removed
_HOST_NAME = re.sub("[^A-Za-z0-9.]", "_", os.uname().nodename)[:64]
_MAX_NAME_TAIL = 40  # characters of a name, its suffix among them, that a partial name ends with: 255 bytes hold both
_made: list[Path] = []  # folders that this process has made for output, each after those inside it
_locked: dict[str, int] = {}  # folders of this process, and the open files that hold their locks


def write_checksums(folder: Path) -> None:
    """Writes the checksums of all files below a folder; `sha256sum -c SHA256SUMS` checks them too."""
    (folder / SUMS).write_text(_checksums(folder), encoding="utf-8")


def is_whole(folder: Path) -> bool:
    """Whether a folder still has all files that `write_checksums` found, unchanged."""
    try:
        lines = read_text(folder / SUMS).splitlines()
        return bool(lines) and set(lines) <= set(_checksums(folder).splitlines())
    except (OSError, InputError):
        return False


def _checksums(folder: Path) -> str:
    files = sorted(path for path in folder.rglob("*") if path.is_file() and path.name != SUMS)
    lines = []
    for path in files:
        with path.open("rb") as file:
            lines.append(f"{hashlib.file_digest(file, 'sha256').hexdigest()}  {path.relative_to(folder).as_posix()}\n")
    return "".join(lines)


@contextmanager
def atomic_file(path: Path) -> Iterator[Path]:
    """A name to write to; when the block ends without an error, the file written replaces `path`.

    A symlink is followed. A device, such as /dev/null, is kept and written to.
    """
    _require_name(path)
    target = Path(os.path.realpath(path))
    try:
        if _is_device(target):
            with TemporaryDirectory(prefix="soft-gripper-") as folder:
                partial = Path(folder) / path.name
                yield partial
                with partial.open("rb") as content, os.fdopen(os.open(target, os.O_WRONLY), "wb") as file:
                    shutil.copyfileobj(content, file)
            return
        partial = _partial(target.with_name(path.name))
        try:
            yield partial
            os.replace(partial, target)
        finally:
            with suppress(OSError):
                partial.unlink()
    except OSError as error:
        raise InputError("output", "file", str(path), f"cannot be written: {error.strerror or error}") from None


def _is_device(path: Path) -> bool:
    """Whether a path is a device for characters; raises an OSError for a pipe: writing would wait for a reader."""
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        return False
    if not (stat.S_ISREG(mode) or stat.S_ISCHR(mode)):
        raise OSError(errno.EINVAL, "it is not a regular file")
    return stat.S_ISCHR(mode)


@contextmanager
def atomic_folder(folder: Path) -> Iterator[Path]:
    """A folder to fill; when the block ends without an error, it appears as `folder`.

    If `folder` exists, it keeps its other files: only those of the same names are replaced. It then has the
    checksums of the files that were written, which `is_whole` compares.
    """
    partial = _partial(folder)
    folder.parent.mkdir(parents=True, exist_ok=True)
    for entry in filter(_is_abandoned, folder.parent.glob(f"{_TEMP_PREFIX}*")):
        if entry.name.endswith(f"-{folder.name[-_MAX_NAME_TAIL:]}") and entry.is_dir() and not entry.is_symlink():
            shutil.rmtree(entry, ignore_errors=True)
    partial.mkdir()
    try:
        yield partial
        write_checksums(partial)
        if not folder.is_dir():
            partial.rename(folder)
            return
        (folder / SUMS).unlink(missing_ok=True)  # old checksums are removed first, new ones come last
        files = [path for path in partial.rglob("*") if path.is_file()]
        for file in sorted(files, key=lambda file: file.name == SUMS):
            target = folder / file.relative_to(partial)
            target.parent.mkdir(parents=True, exist_ok=True)
            os.replace(file, target)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def read_folder(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def write_folder(folder: Path, files: Mapping[str, bytes]) -> None:
    """Writes files as `read_folder` returns them, all or nothing; raises an InputError if it cannot be written."""
    try:
        with atomic_folder(folder) as partial:
            for name, content in files.items():
                (partial / name).write_bytes(content)
    except OSError as error:
        raise InputError("output", "folder", str(folder), f"cannot be written: {_reason(error)}") from None


def _partial(path: Path) -> Path:
    """Path of a file or folder that is written until it replaces `path`."""
    return path.with_name(f"{_TEMP_PREFIX}{_HOST_NAME}-{os.getpid()}-{path.name[-_MAX_NAME_TAIL:]}")


def writable_folder(path: Path) -> Path:
    """Makes a folder for output, before any work is done; raises an InputError if it cannot be written to."""
    _try_writing("folder", path, path, "probe")
    with os.scandir(path) as entries:  # what killed processes of this machine left half written, see `atomic_file`
        abandoned = [entry for entry in entries if entry.is_file(follow_symlinks=False) and _is_abandoned(Path(entry))]
    for entry in abandoned:
        with suppress(OSError):  # another user's
            os.unlink(entry)
    return path


def _is_abandoned(path: Path) -> bool:
    """Whether a path is a `_partial` one of a process of this machine that has ended."""
    host, _, rest = path.name.removeprefix(_TEMP_PREFIX).partition("-")
    pid, _, _ = rest.partition("-")
    if not (path.name.startswith(_TEMP_PREFIX) and host == _HOST_NAME and pid.isdecimal()):
        return False
    try:
        os.kill(int(pid), 0)
    except (ProcessLookupError, OverflowError):
        return True
    except PermissionError:
        pass
    return False


def check_file(path: Path, reads: Iterable[Path | str] = ()) -> None:
    """Raises an InputError if a file cannot be written, or is one that the command reads; makes the folder for it."""
    _require_name(path)
    _keep_inputs(reads, [path])
    try:
        target = Path(os.path.realpath(path))
        is_device = _is_device(target)
    except (OSError, ValueError) as error:
        raise InputError("output", "file", str(path), f"cannot be written: {_reason(error)}") from None
    if not is_device:
        _try_writing("file", path, target.parent, path.name)


def _keep_inputs(inputs: Iterable[Path | str], outputs: Iterable[Path]) -> None:
    for output, file in itertools.product(outputs, list(inputs)):
        try:
            would_be_lost = output.samefile(file) and not _is_device(output)
        except (OSError, ValueError):  # there is no such file
            continue
        if would_be_lost:
            expected = "is an input of this command, and would be lost: name another file"
            raise InputError("output", "file", str(output), expected)


def _require_name(path: Path) -> None:
    if not path.name or os.path.isdir(path):
        raise InputError("output", "file", str(path), "cannot be written: it is a folder; name a file")


def _try_writing(field: str, output: Path, folder: Path, name: str) -> None:
    try:
        absolute_folder = folder.absolute()
        _made[:0] = [path for path in (absolute_folder, *absolute_folder.parents) if not path.exists()]
        folder.mkdir(parents=True, exist_ok=True)
        probe = _partial(folder / name)
        probe.touch()
        probe.unlink()
    except (OSError, ValueError) as error:
        raise InputError("output", field, str(output), f"cannot be written to: {_reason(error)}") from None


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)


def lock_folder(path: Path, writes: Iterable[Path | str] = (), reads: Iterable[Path | str] = ()) -> Path:
    """Makes a folder, and keeps other processes from writing to it until `release_folders` or the end of this process.

    The command `writes` files there, by their names, and `reads` others, none of which may be replaced. Raises an
    InputError if the folder cannot be written to, another process has locked it, or a file would be lost.
    """
    _keep_inputs(reads, [path / name for name in writes])
    folder = writable_folder(path)
    name = os.path.realpath(folder)
    if name not in _locked:
        lock = os.open(name, os.O_RDONLY)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            expected = "another soft-gripper writes there; wait for it, or give another folder"
            raise InputError("output", "folder", str(folder), expected) from None
        except OSError:
            pass  # a file system without locks
        _locked[name] = lock
    return folder


def release_folders() -> None:
    """Removes the empty folders that this process has made, and unlocks its locked ones."""
    for folder in _made:
        with suppress(OSError):  # not empty, or gone
            folder.rmdir()
    _made.clear()
    while _locked:
        os.close(_locked.popitem()[1])


def next_folder(folder: Path) -> Path:
    return next(candidate for candidate in (folder / str(i) for i in itertools.count(1)) if not candidate.exists())
