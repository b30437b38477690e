"""Mistakes and failures, reported in one line."""

import difflib
from collections.abc import Iterable

_LONGEST_VALUE = 200  # characters of a value that a message repeats
_LONGEST_PART = 800  # of its other parts


class InputError(ValueError):
    """Something the user wrote is wrong; its one line names the place, the value, and what would be right."""

    def __init__(self, where: object, field: str, value: object, expected: str):
        super().__init__(where, field, value, expected)
        self.where, self.field, self.value, self.expected = where, field, value, expected

    def __str__(self) -> str:
        where, field, expected = (shortened(str(part)) for part in (self.where, self.field, self.expected))
        return in_one_line(f"{where}: {field} = {_shown(self.value)}: {expected}")

    def inside(self, place: object) -> "InputError":
        """This error, reported from the file or option that contains the mistake."""
        return InputError(f"{place}: {self.where}", self.field, self.value, self.expected)


class SimulationDivergedError(RuntimeError):
    """The state is no longer finite; the message names the time, the state and the likely cause."""


class WorkerDiedError(RuntimeError):
    """The process that made a call died each time; the message names the call."""


def meant(name: object, known: Iterable[str]) -> str:
    """A hint beside a name that is not known: the nearest of those that are, or all of them."""
    names = list(known)
    near = difflib.get_close_matches(str(name), names, n=1)
    return f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"


def is_near(name: object, known: Iterable[str]) -> bool:
    """Whether a name that is not known is most likely one of those, mistyped."""
    return bool(difflib.get_close_matches(str(name), list(known), n=1, cutoff=0.8))


def first_line(error: BaseException) -> str:
    """The first line of an exception's message."""
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__


def described(error: BaseException) -> str:
    """The type of an exception and the first line of its message."""
    if isinstance(error, SystemExit):
        return f"sys.exit({'' if error.code is None else repr(error.code)}) was called"
    said = first_line(error)
    return said if said == type(error).__name__ else f"{type(error).__name__}: {said}"


def in_one_line(text: str) -> str:
    """Text without characters that break the line or move the cursor of a terminal."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def _shown(value: object) -> str:
    """A value as a message repeats it."""
    try:
        return shortened(repr(value), _LONGEST_VALUE)
    except ValueError:  # Python's own limit
        return "a number of thousands of digits"


def shortened(text: str, longest: int = _LONGEST_PART) -> str:
    """A text without its middle, if it is long."""
    return text if len(text) <= longest else f"{text[: longest // 2]} ... {text[-longest // 2 :]}"
