"""Times at which the phases of a task ran, s: signal `task.phase` of a recording -> a `Span` of each."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from soft_gripper.control.task import Phase
from soft_gripper.diagrams.recording import Recording


class Span(NamedTuple):
    """A phase as executed."""

    phase: Phase
    begin: float  # s
    end: float


def phase_spans(recording: Recording, phases: Sequence[Phase]) -> list[Span]:
    """The phases in the order of execution, without the time after the last.

    `phases` are those of the TaskMachine, including rescues, by number.
    """
    signal = recording["task.phase"]
    times, numbers = signal["time"].values, signal.values.astype(int)
    bounds = pairwise([0, *(np.flatnonzero(np.diff(numbers)) + 1), len(times) - 1])
    return [
        Span(phases[numbers[begin]], float(times[begin]), float(times[end]))
        for begin, end in bounds
        if numbers[begin] < len(phases) and begin < end
    ]
