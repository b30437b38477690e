"""Delays Ctrl-C, SIGTERM and SIGHUP while work must not be left half done."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

ENDS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)  # the last as a terminal is closed
_REPEAT_TIME = 0.5  # s within which several signals are one: `timeout` and terminals send them twice


@contextmanager
def waiting() -> Iterator[None]:
    """Delays Ctrl-C, SIGTERM and SIGHUP while modules are imported.

    Libraries catch any exception of their optional imports, SystemExit too, and would go on as if nothing had happened.
    """
    old_mask = signal.pthread_sigmask(signal.SIG_BLOCK, ENDS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, old_mask)


@contextmanager
def held_back() -> Iterator[Callable[[], bool]]:
    """Holds Ctrl-C, SIGTERM and SIGHUP back within the block; yields a function that returns whether one has arrived.

    An exception in the middle of a frame would leave logs of unequal lengths, and so no recording; nor would there be
    one after an exception while it is being written. A second signal, half a second later or more, ends the process at
    once. A signal that the process ignores, such as SIGHUP under nohup, stays ignored.
    """
    signal_times: list[float] = []

    def note(number: int, _: object) -> None:
        if signal_times and time.monotonic() > signal_times[0] + _REPEAT_TIME:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)
        signal_times.append(time.monotonic())

    with _signal_handler(note):
        yield lambda: bool(signal_times)


@contextmanager
def delayed_signals() -> Iterator[None]:
    """Delays Ctrl-C, SIGTERM and SIGHUP until the block ends, so that the block is done whole or not at all.

    Unlike `waiting`, it serves a process with threads, any of which may receive a signal. Outside the main thread,
    where Python handles no signal, it does nothing. If the block raises an exception, that alone is raised.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers: list[int] = []
    with _signal_handler(lambda number, _: numbers.append(number)):
        yield
    if numbers:
        signal.raise_signal(numbers[0])


@contextmanager
def _signal_handler(handle: Callable[[int, Any], Any]) -> Iterator[None]:
    """Replaces the handlers of the signals within the block; a signal that the process ignores stays ignored."""
    handlers = {number: handler for number in ENDS if callable(handler := signal.getsignal(number))}
    for number in handlers:
        signal.signal(number, handle)
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
