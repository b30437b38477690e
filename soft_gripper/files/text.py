"""Files supplied by the user."""

import os
from pathlib import Path

from soft_gripper.errors import InputError


def name_of(name_or_path: object) -> str:
    """The name of something shipped, or a path, as text.

    Raises:
        InputError: if it is neither.
    """
    if not isinstance(name_or_path, str | Path):
        raise InputError("file", "name", name_or_path, "give a name or a path, as text")
    return str(name_or_path)


def check_regular(path: Path) -> None:
    """Checks a file before it is opened: reading from a pipe would block.

    Raises:
        InputError: if there is none, or it is not a regular file.
    """
    try:
        os.stat(path)  # reports what is wrong, such as a loop of symlinks
        if not os.path.isfile(path):
            raise InputError(path, "file", path.name, "cannot be read: it is not a regular file")
    except OSError as error:
        raise InputError(path, "file", path.name, f"cannot be read: {error.strerror}") from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError("file", "name", str(path), f"cannot be read: {error}") from None


def read_text(path: Path) -> str:
    """The text of a regular file, UTF-8, with or without a byte order mark.

    Raises:
        InputError: if the file cannot be read, or is not a regular file.
    """
    check_regular(path)
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, "file", path.name, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(path, "file", path.name, "cannot be read: it is not a text file") from None
