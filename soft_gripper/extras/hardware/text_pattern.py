"""Plain patterns of names: text with placeholders. They take time in proportion to the text, whoever wrote them.

`{number}` stands for digits, perhaps with a decimal point, and `{word}` for letters; other placeholders are replaced
by what the reader puts there.
"""

import re
from collections.abc import Iterator, Mapping, Sequence

_FIELD = re.compile(r"\{([^{}]*)\}")
_OLD_NUMBERS = r"(\d+(?:\.\d+)?)", r"(\d+)"  # regular expressions of earlier descriptions, read as {number}
_SYNTAX = frozenset("\\()[]?*+^$")  # of regular expressions
# What a placeholder matches, and what may not be before it at the beginning of a pattern: a part of the same.
# Quantifiers are possessive, and give nothing back.
_MATCHED = {"number": (r"([0-9]++(?:\.[0-9]++)?+)", r"(?<![0-9.,])"), "word": (r"([^\W\d_]++)", r"(?<![^\W\d_])")}
MAX_LENGTH = 200  # characters of a pattern


def pattern_problem(pattern: str, required: Sequence[str] = (), known: Sequence[str] = ()) -> str | None:
    """Sentence on how a pattern would have to be; None if it is valid.

    Args:
        pattern: the text.
        required: placeholders that it must have, once or more.
        known: others that it may have.
    """
    if len(pattern) > MAX_LENGTH:
        return f"must have at most {MAX_LENGTH} characters"
    placeholders = _FIELD.findall(pattern)
    shown = " and ".join(f"{{{name}}}" for name in required)
    if any(name not in placeholders for name in required):
        return f"must have {shown}"
    if unknown := [name for name in placeholders if name not in (*required, *known)]:
        allowed = ", ".join(f"{{{name}}}" for name in (*required, *known)) or "none"
        return f"has {{{unknown[0]}}}, and the placeholders are: {allowed}"
    return None


def filled(pattern: str, values: Mapping[str, str]) -> str:
    """A pattern with texts in the place of its placeholders."""
    return _FIELD.sub(lambda field: values.get(field[1], field[0]), pattern)


def plain_number_pattern(pattern: str) -> str:
    """A pattern of a number in which the regular expressions of earlier descriptions, such as `_(\\d+)g`, are plain."""
    for old in _OLD_NUMBERS:
        plain = pattern.replace(old, "{number}")
        if plain != pattern and (_SYNTAX | set(".|")).isdisjoint(plain):
            return plain
    return pattern


def has_syntax(pattern: str) -> bool:
    """Whether a pattern seems to be a regular expression."""
    return not _SYNTAX.isdisjoint(pattern)


def find(pattern: str, text: str) -> re.Match[str] | None:
    """The first place of a text that a pattern with {number} and {word} matches, with these as its groups."""
    return re.search("".join(_expressions(pattern)), text)


def _expressions(pattern: str) -> Iterator[str]:
    end = 0
    for field in _FIELD.finditer(pattern):
        matched, boundary = _MATCHED[field[1]]
        yield re.escape(pattern[end : field.start()]) + (boundary if field.start() == 0 else "") + matched
        end = field.end()
    yield re.escape(pattern[end:])
