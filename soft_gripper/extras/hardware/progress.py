"""Shows the progress of calls in other processes."""

import sys
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import Any

from tqdm import tqdm

_TERMINAL_PERIOD, _LOG_PERIOD = 1.0, 10.0  # s, between two reports while no call ends


def wait_for(calls: Sequence["Future[Any]"], title: str, unit: str) -> None:
    """Waits until all calls have ended; stderr shows their number and the time."""
    period = _TERMINAL_PERIOD if sys.stderr.isatty() else _LOG_PERIOD
    with tqdm(total=len(calls), desc=title, unit=unit, dynamic_ncols=True) as bar:
        unfinished_calls = set(calls)
        while unfinished_calls:
            finished_calls, unfinished_calls = wait(unfinished_calls, period, FIRST_COMPLETED)
            bar.update(len(finished_calls))
            bar.refresh()
