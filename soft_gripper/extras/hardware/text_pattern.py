"""Matches plain patterns of names: text with placeholders. The time is proportional to the text, whoever wrote it.

`{number}` stands for digits, perhaps with a decimal point, and `{word}` for letters: `_PLACEHOLDERS`. `fill_pattern`
replaces the others.
"""

import re
from collections.abc import Iterator, Mapping, Sequence

_PLACEHOLDER = re.compile(r"\{([^{}]*)\}")
_NUMBER_EXPRESSIONS = r"(\d+(?:\.\d+)?)", r"(\d+)"  # regular expressions of earlier descriptions, read as {number}
_EXPRESSION_SIGNS = frozenset("\\()[]?*+^$")  # of regular expressions
# Expression of a placeholder, and of its boundary at the beginning of a pattern, which rejects a part of the same.
# Quantifiers are possessive, and give nothing back.
_PLACEHOLDERS = {"number": (r"([0-9]++(?:\.[0-9]++)?+)", r"(?<![0-9.,])"), "word": (r"([^\W\d_]++)", r"(?<![^\W\d_])")}
MAX_LENGTH = 200  # characters of a pattern


def pattern_problem(pattern: str, required: Sequence[str] = (), optional: Sequence[str] = ()) -> str | None:
    """Text that names the rule that a pattern violates; None if it is valid.

    Args:
        pattern: the text.
        required: placeholders that it must have, once or more.
        optional: others that it may have.
    """
    if len(pattern) > MAX_LENGTH:
        return f"must have at most {MAX_LENGTH} characters"
    placeholders = _PLACEHOLDER.findall(pattern)
    required_text = " and ".join(f"{{{name}}}" for name in required)
    if any(name not in placeholders for name in required):
        return f"must have {required_text}"
    if unknown_names := [name for name in placeholders if name not in (*required, *optional)]:
        allowed_text = ", ".join(f"{{{name}}}" for name in (*required, *optional)) or "none"
        return f"has {{{unknown_names[0]}}}, and the placeholders are: {allowed_text}"
    return None


def fill_pattern(pattern: str, values: Mapping[str, str]) -> str:
    """Replaces the placeholders of a pattern by texts."""
    return _PLACEHOLDER.sub(lambda field: values.get(field[1], field[0]), pattern)


def plain_number_pattern(pattern: str) -> str:
    """Pattern of a number without the regular expressions of earlier descriptions, such as `_(\\d+)g`."""
    for expression in _NUMBER_EXPRESSIONS:
        plain_pattern = pattern.replace(expression, "{number}")
        if plain_pattern != pattern and (_EXPRESSION_SIGNS | set(".|")).isdisjoint(plain_pattern):
            return plain_pattern
    return pattern


def has_syntax(pattern: str) -> bool:
    """Whether a pattern seems to be a regular expression."""
    return not _EXPRESSION_SIGNS.isdisjoint(pattern)


def find(pattern: str, text: str) -> re.Match[str] | None:
    """First match of a pattern in a text, with {number} and {word} as its groups."""
    return re.search("".join(_expressions(pattern)), text)


def _expressions(pattern: str) -> Iterator[str]:
    end = 0
    for field in _PLACEHOLDER.finditer(pattern):
        expression, boundary = _PLACEHOLDERS[field[1]]
        yield re.escape(pattern[end : field.start()]) + (boundary if field.start() == 0 else "") + expression
        end = field.end()
    yield re.escape(pattern[end:])
