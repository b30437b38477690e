"""Text from users -> numbers, in digits 0 to 9 alone: float() of Python takes 1_0, other digits and words too."""

import math
import re

# Quantifiers are possessive: a million digits that are not a number are read once.
DECIMAL = r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?+|\.[0-9]++)(?:e[-+]?[0-9]++)?+"
_DECIMAL_PATTERN = re.compile(DECIMAL, re.IGNORECASE)
CHANGE = 'or a change such as "+10 %"'  # for messages


def is_number(text: str) -> bool:
    return _DECIMAL_PATTERN.fullmatch(text) is not None


def number(text: str) -> float:
    """The number that a text is, infinite beyond the range of a float; raises a ValueError if it is not decimal."""
    text = text.strip()
    if not is_number(text):
        raise ValueError(f"not a number: {text[:30]!r}")
    return float(text)


def changed(text: str, old_value: float) -> float:
    """A finite number, or a change of the old value such as "+10 %"; raises a ValueError if the text is neither."""
    size, percent, rest = text.partition("%")
    value, sign = number(size), size.strip()[0]
    is_wrong = sign not in "+-" if percent else sign == "+"
    if is_wrong or rest.strip() or not math.isfinite(value):
        raise ValueError(f"neither a number nor a change: {text[:30]!r}")
    return old_value * (1 + value / 100) if percent else value
