"""Ctrl-C and SIGTERM, held back until they break nothing in two."""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_NUMBERS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def held_back() -> Iterator[Callable[[], None]]:
    """Holds them back within the block; what it yields lets one through, if there is one, when it is called.

    An exception out of the middle of a frame would leave logs of unequal lengths, and no recording.
    """
    pending: list[int] = []
    handlers = {number: handler for number in _NUMBERS if callable(handler := signal.getsignal(number))}
    for number in handlers:
        signal.signal(number, lambda number, _: pending.append(number))

    def let_through() -> None:
        if pending:
            number = pending.pop(0)
            handlers[signal.Signals(number)](number, None)

    try:
        yield let_through
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
