"""What libraries complain of on the way, as lines of our own."""

import logging
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from soft_gripper.diagrams.loading.drake_reading import of_drake
from soft_gripper.errors import in_one_line

_MOST = 5  # notes of a command


class _Notes(logging.Handler):
    """Prints each message once, in one line."""

    def __init__(self) -> None:
        super().__init__()
        self._seen: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        self.note(of_drake(record.getMessage()))

    def note(self, message: str) -> None:
        text = in_one_line(" ".join(message.split()))
        if text in self._seen or len(self._seen) > _MOST:
            return
        self._seen.add(text)
        print(f"note: {text}" if len(self._seen) <= _MOST else "note: ... and more", file=sys.stderr)


@contextmanager
def notes() -> Iterator[None]:
    """Makes notes of what Drake logs and of Python's warnings, of which numbers out of range are the most."""
    drake, handler = logging.getLogger("drake"), _Notes()

    def show(message: Warning | str, category: type[Warning], *_: Any) -> None:
        handler.note(f"numbers out of range: {message}" if issubclass(category, RuntimeWarning) else str(message))

    before = drake.handlers, drake.propagate, drake.level
    drake.handlers, drake.propagate = [handler], False
    try:
        with warnings.catch_warnings():
            warnings.showwarning = show  # type: ignore[assignment]
            yield
    finally:
        drake.handlers, drake.propagate = before[:2]
        drake.setLevel(before[2])
