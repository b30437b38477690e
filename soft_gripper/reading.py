"""Text files of the user's."""

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


def read_text(path: Path) -> str:
    """The text of a regular file, UTF-8, with or without a mark at its beginning.

    Raises:
        InputError: if the file cannot be read. What is no regular file is not opened: a pipe would be waited for.
    """
    try:
        os.stat(path)  # says what is wrong, as a loop of symlinks
        if not os.path.isfile(path):
            raise InputError(path, "file", path.name, "cannot be read: it is no regular file")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(path, "file", path.name, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(path, "file", path.name, "cannot be read: it is not a text file") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError("file", "name", str(path), f"cannot be read: {error}") from None
