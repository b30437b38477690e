"""Ctrl-C and its like, held back while something must not be left half done."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # the last as a terminal is closed


@contextmanager
def held_back() -> Iterator[Callable[[], bool]]:
    """Holds Ctrl-C, SIGTERM and SIGHUP back within the block; yields a function that returns whether one has arrived.

    An exception in the middle of a frame would leave logs of unequal lengths, and so no recording; nor would there be
    one after an exception while it is being written. A signal that the process ignores, such as SIGHUP
    under nohup, stays ignored.
    """
    came: list[int] = []
    handlers = {number: handler for number in ENDS if callable(handler := signal.getsignal(number))}
    for number in handlers:
        signal.signal(number, lambda number, _: came.append(number))
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
