"""Messages of libraries, printed as notes of one line each."""

import logging
import re
import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from soft_gripper.errors import single_line

# The temporary folder in which Drake reads a file made from another one, and what is added to the file's name.
PREFIX, MARK = "soft-gripper-", ".expanded"
_OWN_FOLDER = re.compile(rf"/\S*/{PREFIX}[^/\s]+/([^/\s]+){re.escape(MARK)}")
_MAX_LIBRARY_NOTES, _MAX_OWN_NOTES = 5, 20  # notes of a command: of libraries, and our own
_DRAKE_LOGGER = "drake"  # the logger whose level a command may lower


def original_message(message: str) -> str:
    """A message from Drake, with the names of temporary files replaced by those of the files they were made from."""
    return _OWN_FOLDER.sub(r"\1", message)


class _NotePrinter(logging.Handler):
    def __init__(self) -> None:
        super().__init__()
        self._seen: dict[int, set[str]] = {_MAX_LIBRARY_NOTES: set(), _MAX_OWN_NOTES: set()}

    def emit(self, record: logging.LogRecord) -> None:
        if record.name == _DRAKE_LOGGER or record.levelno >= logging.WARNING:
            max_count = _MAX_OWN_NOTES if record.name.startswith(__package__) else _MAX_LIBRARY_NOTES
            self.note(original_message(record.getMessage()), max_count)

    def note(self, message: str, max_count: int = _MAX_LIBRARY_NOTES) -> None:
        text, messages = single_line(" ".join(message.split())), self._seen[max_count]
        if text in messages or len(messages) > max_count:
            return
        messages.add(text)
        print(f"note: {text}" if len(messages) <= max_count else "note: ... and more", file=sys.stderr)


@contextmanager
def drop_messages(drop: Callable[[str], bool]) -> Iterator[None]:
    drake = logging.getLogger(_DRAKE_LOGGER)

    def concerns_us(record: logging.LogRecord) -> bool:
        return not drop(record.getMessage())

    drake.addFilter(concerns_us)
    try:
        yield
    finally:
        drake.removeFilter(concerns_us)


@contextmanager
def printed_as_notes() -> Iterator[None]:
    """Prints log messages of libraries, and Python's warnings, as notes; most are about numbers out of range."""
    root, drake, handler = logging.getLogger(), logging.getLogger(_DRAKE_LOGGER), _NotePrinter()

    def show(message: Warning | str, category: type[Warning], *_: Any) -> None:
        handler.note(f"numbers out of range: {message}" if issubclass(category, RuntimeWarning) else str(message))

    old_handlers = root.handlers, drake.handlers, drake.level
    root.handlers, drake.handlers = [handler], []
    try:
        with warnings.catch_warnings():
            warnings.showwarning = show  # type: ignore[assignment]
            yield
    finally:
        root.handlers, drake.handlers = old_handlers[:2]
        drake.setLevel(old_handlers[2])
