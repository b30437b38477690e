"""Text from users -> numbers, in digits 0 to 9 alone: float() of Python takes 1_0, other digits and words too."""

import re

# Quantifiers are possessive: a million digits that are not a number are read once.
DECIMAL = r"[-+]?(?:[0-9]++(?:\.[0-9]*+)?+|\.[0-9]++)(?:e[-+]?[0-9]++)?+"
_DECIMAL = re.compile(DECIMAL, re.IGNORECASE)


def is_number(text: str) -> bool:
    """Whether a text is a decimal number, perhaps with an exponent."""
    return _DECIMAL.fullmatch(text) is not None


def number(text: str) -> float:
    """The number that a text is, spaces around it aside; infinite beyond the range of a float.

    Raises:
        ValueError: if it is not a decimal number.
    """
    text = text.strip()
    if not is_number(text):
        raise ValueError(f"not a number: {text[:30]!r}")
    return float(text)
