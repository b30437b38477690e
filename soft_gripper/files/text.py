"""Files supplied by the user: the only place where their bytes and their text are read."""

import codecs
import os
from pathlib import Path

from soft_gripper.errors import InputError

MAX_BYTES = 2**28  # of a file that is read at once: half an hour of a log of 20 columns at 1 kHz
MAX_TEXT_BYTES = 2**25  # of a model, a description or a document
_LFS_POINTER = b"version https://git-lfs.github.com/spec/"
_BYTE_ORDER_MARKS = (  # those of UTF-32 begin like those of UTF-16
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


def name_of(name_or_path: object) -> str:
    """The name of something shipped, or a path, as text; raises an InputError if it is neither."""
    if not isinstance(name_or_path, str | Path):
        raise InputError("file", "name", name_or_path, "give a name or a path, as text")
    return str(name_or_path)


def check_regular(path: Path, max_bytes: int | None = None) -> None:
    """Checks a file before it is opened: reading from a pipe would block, and from a device it may never end.

    Raises an InputError if there is none, it is not regular, it has more than `max_bytes` (None: any number), or a
    pointer of Git LFS is in its place.
    """
    _read_beginning(path, len(_LFS_POINTER), max_bytes)


def read_bytes(path: Path, max_bytes: int = MAX_BYTES) -> bytes:
    """The content of a regular file; raises as `check_regular`, or if the file cannot be read."""
    data = _read_beginning(path, max_bytes + 1, max_bytes)
    _check_size(path, len(data), max_bytes)  # some files of /proc say that they are empty
    return data


def read_text(path: Path, max_bytes: int = MAX_TEXT_BYTES) -> str:
    """The text of a regular file, in UTF-8, -16 or -32; raises as `read_bytes`, or an InputError if it is not text."""
    return decode(path, read_bytes(path, max_bytes))


def _read_beginning(path: Path, count: int, max_bytes: int | None) -> bytes:
    """The first `count` bytes of a file, which is checked."""
    try:
        size = os.stat(path).st_size  # reports what is wrong, such as a loop of symlinks
        if not os.path.isfile(path):
            raise InputError(path, "file", path.name, "cannot be read: it is not a regular file")
        _check_size(path, size, max_bytes)
        # No read waits: some files of /proc are regular, and wait for data.
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
            data = file.read(count)
        if data is None:
            raise InputError(path, "file", path.name, "cannot be read: it waits for what others write")
    except OSError as error:
        raise InputError(path, "file", path.name, f"cannot be read: {error.strerror}") from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError("file", "name", str(path), f"cannot be read: {error}") from None
    if data.startswith(_LFS_POINTER):
        raise InputError(path, "file", path.name, "is a pointer of Git LFS: git lfs pull")
    return data


def _check_size(path: Path, size: int, max_bytes: int | None) -> None:
    if max_bytes is not None and size > max_bytes:
        raise InputError(path, "size", size, f"give a file of at most {max_bytes} bytes")


def decode(path: Path, data: bytes, encoding: str | None = None, fallback: str | None = None) -> str:
    """Bytes of a file as text; raises an InputError if they are not.

    Without an `encoding`, a byte order mark gives it, or it is UTF-8; a log has a `fallback` for what is not UTF-8.
    """
    marked_encoding = next((name for mark, name in _BYTE_ORDER_MARKS if data.startswith(mark)), "utf-8")
    if len(data) > 3 and not data[1:64:2].strip(b"\0") and data[0]:
        marked_encoding = "utf-16-le"  # as some write it, without a mark
    candidates = [encoding or marked_encoding]
    if fallback is not None and encoding is None and b"\0" not in data:
        candidates.append(fallback)
    for candidate in candidates:
        try:
            # A log may end within a character. Newlines of all systems are one.
            text = codecs.getincrementaldecoder(candidate)().decode(data, final=fallback is None)
            return text.replace("\r\n", "\n").replace("\r", "\n")
        except UnicodeDecodeError:
            continue
        except LookupError:
            raise InputError(path, "text.encoding", encoding, "is not an encoding of Python, such as latin-1") from None
    raise InputError(path, "file", path.name, "cannot be read: it is not a text file")
