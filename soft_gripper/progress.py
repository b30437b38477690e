"""Progress bars on a terminal or in a notebook."""

import sys
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import parent_process
from typing import Any

from tqdm import TqdmWarning, tqdm

SIMULATED = "{n:.0f}/{total:.0f} s simulated [{elapsed}<{remaining}]"
_BAR_DELAY = 2.0  # s that a run takes without a bar
_DRAWING_PERIOD = 0.5  # s, so that drawing takes no time from the run


def simulated_seconds(total: float, name: str, **settings: Any) -> "tqdm[None]":
    """A progress bar of simulated seconds; `settings` go to tqdm."""
    form = f"{{desc}} {{bar}} {SIMULATED}"
    settings |= {"mininterval": _DRAWING_PERIOD, "dynamic_ncols": True}
    bar_type = tqdm
    if _is_notebook():
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", TqdmWarning)  # without ipywidgets the bar is text
            from tqdm import auto

            bar_type = auto.tqdm
    return bar_type(total=total, desc=name, bar_format=form, **settings)


@contextmanager
def run_progress(bar: "tqdm[None]") -> Iterator[Callable[[float], None]]:
    """Yields a function that sets a bar to the simulated time, s; at the end the bar is full."""
    with bar:
        yield lambda time: bar.update(time - bar.n)
        bar.total = bar.n  # a task may end before its time limit


@contextmanager
def progress_of_long_runs(duration: float) -> Iterator[Callable[[float], None] | None]:
    """Shows the progress of a run of up to `duration` s that takes long; None without a terminal or notebook."""
    if parent_process() is not None or not (sys.stderr.isatty() or _is_notebook()):
        yield None
        return
    with run_progress(simulated_seconds(duration, "simulate", delay=_BAR_DELAY, leave=False)) as progress:
        yield progress


def _is_notebook() -> bool:
    """Whether IPython runs this process for a notebook, not in a terminal."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return hasattr(shell, "kernel")
