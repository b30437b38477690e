"""A progress bar in simulated seconds."""

from collections.abc import Iterator
from contextlib import contextmanager

from tqdm import tqdm

from soft_gripper.diagrams.simulation import Progress

BAR = "{desc} {bar} {n:.0f}/{total:.0f} s simulated [{elapsed}<{remaining}]"


@contextmanager
def progress_bar(name: str, duration: float) -> Iterator[Progress]:
    """Shows on a terminal how far a run of `duration` s has come; give what it yields to `simulate`."""
    with tqdm(total=duration, desc=name, bar_format=BAR, dynamic_ncols=True, disable=None) as bar:
        yield lambda time: bar.update(time - bar.n)
        bar.total = bar.n  # a task may be over before its time limit
        bar.refresh()
