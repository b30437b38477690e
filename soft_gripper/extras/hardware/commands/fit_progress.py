"""Reports a fit: prints its figure of merit after each step, and writes the best finger so far to its file."""

import sys
import time
from collections.abc import Callable

import numpy as np

from soft_gripper.extras.hardware.identification.free_parameters import Model
from soft_gripper.extras.hardware.least_squares import Progress


class FitProgress:
    """Prints a line for each step, and writes the finger that is the best so far.

    `write` is called with the model and a remark that says how far the search has come.
    """

    def __init__(self, title: str, write: Callable[[Model, str], None]):
        self._title, self._write = title, write
        self._best, self._begin = np.inf, time.monotonic()

    def __call__(self, progress: Progress[Model]) -> None:
        """Reports a step."""
        error = f"marker error {100 * progress.error:.2f} %"
        unbalanced = f", {progress.missing // 3} markers in no balance" if progress.missing else ""
        elapsed = f"{time.monotonic() - self._begin:.0f} s"
        print(f"{self._title}: step {progress.step}, {error}{unbalanced}, {elapsed}", file=sys.stderr, flush=True)
        if progress.error < self._best:
            self._best = progress.error
            self._write(progress.model, f"Not final: the search had come to step {progress.step}, {error}")
