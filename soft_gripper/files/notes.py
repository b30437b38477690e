"""Notes on files supplied by the user: what was mended or left out while they were read, so that nothing is in silence.

A reader calls `note`, or leaves notes to its caller, who calls `report`; `collect_notes` gathers the notes of all
readers inside it, logs them once, and leaves them to its caller, who keeps them: a recording has them in its attribute
`notes`, one a line.
"""

import logging
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import NamedTuple

from soft_gripper.errors import shortened, single_line

_LOGGER = logging.getLogger(__name__)
READ, MENDED, LEFT_OUT = "read", "mended", "left out"
_MAX_SUBJECTS = 3  # elements of a line that a command prints
_LONGEST_VALUE = 60  # characters of a value


class Note(NamedTuple):
    """Note on an element of a file: it was read as an assumption, mended, or left out."""

    outcome: str  # READ, MENDED or LEFT_OUT
    file: str
    element: str  # such as "joint 'elbow': dynamics.friction"
    value: str  # as the file gives it; "" if that is nothing to repeat
    why: str

    @property
    def subject(self) -> str:
        return f"{self.element} = {self.value}" if self.value else self.element

    def __str__(self) -> str:
        return f"{self.file}: {self.outcome} {self.subject}: {self.why}"


_open: ContextVar[list[Note] | None] = ContextVar("open", default=None)  # the innermost collection


def make_note(outcome: str, file: Path | str, element: str, value: object, why: str) -> Note:
    """A note in one line, with its value shortened as in a message."""
    return Note(outcome, str(file), single_line(element), shortened(single_line(str(value)), _LONGEST_VALUE), why)


def note(outcome: str, file: Path | str, element: str, value: object, why: str) -> None:
    report([make_note(outcome, file, element, value, why)])


def report(made: Iterable[Note]) -> None:
    """Adds notes to the innermost `collect_notes`, or logs each at once if there is none."""
    notes = _open.get()
    for entry in made:
        if notes is None:
            _log([entry])
        elif entry not in notes:
            notes.append(entry)


@contextmanager
def collect_notes() -> Iterator[list[Note]]:
    """Collects the notes made inside.

    At the end they go to the collection around it, or to the log; none do if an error ends it.
    """
    notes, outer_notes = list[Note](), _open.get()
    token = _open.set(notes)
    try:
        yield notes
    finally:
        _open.reset(token)
    if outer_notes is None:
        _log(notes)
    else:
        outer_notes += [entry for entry in notes if entry not in outer_notes]


def as_text(notes: Iterable[Note]) -> str:
    """Notes, one per line, in the form that a recording keeps."""
    return "\n".join(map(str, notes))


def _log(notes: Iterable[Note]) -> None:
    for line in summarize(notes):
        _LOGGER.warning("%s", line)


def summarize(notes: Iterable[Note]) -> list[str]:
    """A line for all notes that differ only in the element, which names the first of these."""
    subjects_by_note: dict[tuple[str, str, str], list[str]] = {}
    for entry in notes:
        subjects_by_note.setdefault((entry.file, entry.outcome, entry.why), []).append(entry.subject)
    lines = []
    for (file, outcome, why), subjects in subjects_by_note.items():
        more = f" and {len(subjects) - _MAX_SUBJECTS} more" if len(subjects) > _MAX_SUBJECTS else ""
        lines.append(f"{Path(file).name}: {outcome} {', '.join(subjects[:_MAX_SUBJECTS])}{more}: {why}")
    return lines
