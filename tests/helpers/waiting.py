"""Waiting for a condition instead of a time, on a machine however busy."""

import time
from collections.abc import Callable

LONG = 300.0  # s, for whatever a busy machine may take


def wait_until(holds: Callable[[], object]) -> None:
    """Returns once a condition holds; fails if that takes LONG."""
    deadline = time.monotonic() + LONG
    while not holds():
        assert time.monotonic() < deadline, "it takes too long"
        time.sleep(0.05)
