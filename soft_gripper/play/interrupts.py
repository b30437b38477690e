"""Ctrl-C, SIGTERM and a closed terminal as the end of a session, held back until they break nothing in two."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_NUMBERS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@contextmanager
def held_back() -> Iterator[Callable[[], bool]]:
    """Holds these signals back within the block; what it yields says whether one has come.

    An exception out of the middle of a frame would leave logs of unequal lengths, and no recording; one while a
    recording is being written, none either. A signal that the process ignores, as SIGHUP below nohup, stays ignored.
    """
    came: list[int] = []
    handlers = {number: handler for number in _NUMBERS if callable(handler := signal.getsignal(number))}
    for number in handlers:
        signal.signal(number, lambda number, _: came.append(number))
    try:
        yield lambda: bool(came)
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
