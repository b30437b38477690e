"""Errors of user input and failed simulations, each reported in one line."""

import difflib
import re
from collections.abc import Iterable

_MAX_VALUE_LENGTH = 200  # characters of a value that a message repeats
_MAX_PART_LENGTH = 800  # of its other parts
_MAX_NAME = 100  # characters of names that are compared
_MAX_SUGGESTIONS = 3
_MIN_LIKENESS = 0.8  # ratio of difflib; of 'simulation' and 'visualization' it is 0.78
_MIN_PART_LENGTH = 3  # characters of a part of a name


class InputError(ValueError):
    """Something the user wrote is wrong; its one line names the place, the value, and what would be right."""

    def __init__(self, where: object, field: str, value: object, expected: str):
        super().__init__(where, field, value, expected)
        self.where, self.field, self.value, self.expected = where, field, value, expected

    def __str__(self) -> str:
        where, field, expected = (shortened(str(part)) for part in (self.where, self.field, self.expected))
        try:
            value = shortened(repr(self.value), _MAX_VALUE_LENGTH)
        except ValueError:  # Python's own limit
            value = "a number of thousands of digits"
        return single_line(f"{where}: {field} = {value}: {expected}")

    def inside(self, place: object) -> "InputError":
        """This error, reported from the file or option that contains the mistake."""
        return InputError(f"{place}: {self.where}", self.field, self.value, self.expected)


class SimulationDivergedError(RuntimeError):
    """The state is no longer finite; the message names the time, the state and the likely cause."""


class WorkerDiedError(RuntimeError):
    """The process that made a call died each time; the message names the call."""


def suggestion(name: object, valid_names: Iterable[str]) -> str:
    """Hint beside an unknown name: the nearest known names, or all of them."""
    names = list(valid_names)
    return did_you_mean(similar_names(name, names)) or f"known: {', '.join(names)}"


def did_you_mean(names: Iterable[str]) -> str:
    """The question whether one of these was meant; empty without any."""
    choices = " or ".join(f"'{name}'" for name in names)
    return f"did you mean {choices}?" if choices else ""


def similar_names(name: object, valid_names: Iterable[str]) -> list[str]:
    """Valid names that an unknown one may stand for: the one spelt like it, then those that contain it.

    A part is the beginning of a name, or all but its first word, as in 'max' for 'maximum' or 'step' for 'time_step'.
    """
    lowered, names = str(name).lower(), list(dict.fromkeys(valid_names))
    is_part = _MIN_PART_LENGTH <= len(lowered) <= _MAX_NAME
    part_pattern = re.compile(rf"{re.escape(lowered)}.*|[^\W_]+[\W_]{re.escape(lowered)}")
    parts = [valid_name for valid_name in names if is_part and part_pattern.fullmatch(valid_name[:_MAX_NAME].lower())]
    return list(dict.fromkeys(_spelt_like(lowered, names) + parts))[:_MAX_SUGGESTIONS]


def _spelt_like(name: str, valid_names: Iterable[str]) -> list[str]:
    """The valid name that differs least in its letters, or only in their order; none if all differ much."""
    own_letters = _letters(name)
    names_by_letters = {_letters(valid_name): valid_name for valid_name in valid_names}
    close_matches = difflib.get_close_matches(own_letters, names_by_letters, n=1, cutoff=_MIN_LIKENESS)
    reorderings = [letters for letters in names_by_letters if sorted(letters) == sorted(own_letters)]
    return [names_by_letters[letters] for letters in (close_matches or reorderings)[:1]]


def _letters(name: str) -> str:
    """The letters and digits of a name, of a long one those of its first characters."""
    return re.sub(r"[\W_]", "", name[:_MAX_NAME].lower())


def is_near(name: object, valid_names: Iterable[str]) -> bool:
    """Whether an unknown name is most likely a valid one, mistyped."""
    return bool(_spelt_like(str(name), valid_names))


def first_line(error: BaseException) -> str:
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__


def described(error: BaseException) -> str:
    """The type of an exception and the first line of its message."""
    if isinstance(error, SystemExit):
        return f"sys.exit({'' if error.code is None else repr(error.code)}) was called"
    message = first_line(error)
    return message if message == type(error).__name__ else f"{type(error).__name__}: {message}"


def single_line(text: str) -> str:
    """Text without characters that break the line or move the cursor of a terminal."""
    return "".join(char if char.isprintable() else repr(char)[1:-1] for char in text)


def shortened(text: str, longest: int = _MAX_PART_LENGTH) -> str:
    """A text without its middle, if it is long."""
    return text if len(text) <= longest else f"{text[: longest // 2]} ... {text[-longest // 2 :]}"
