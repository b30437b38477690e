"""Changes of numbers by dotted keys: a value, or "+10 %" of the one before, which are told apart by their text."""

import math
from collections.abc import Iterator, Mapping
from numbers import Real
from typing import Any

from soft_gripper.files.number import number
from soft_gripper.quantity import Rule

CHANGE = 'or a change such as "+10 %"'  # for messages


def changed(text: str, before: float) -> float:
    """The number after a change, whose sign is required.

    Raises:
        ValueError: if the text is neither a number nor a change of one, or not finite.
    """
    size, percent, rest = text.partition("%")
    value, sign = number(size), size.strip()[0]
    is_wrong = sign not in "+-" if percent else sign == "+"
    if is_wrong or rest.strip() or not math.isfinite(value):
        raise ValueError(f"neither a number nor a change: {text[:30]!r}")
    return before * (1 + value / 100) if percent else value


def change_violation(change: Any, rule: Rule) -> str | None:
    """Sentence on how a change, or the words of a list, would have to be; None if it is valid."""
    text = as_text(change)
    if rule.known:
        is_known = isinstance(text, str) and set(text.split()) <= set(rule.choices)
        return None if is_known else f"must be text of the words {', '.join(rule.choices)}"
    try:
        value = changed(text, math.nan)
    except (ValueError, AttributeError):
        return f"must be a number{f', {rule.unit},' if rule.unit else ','} {CHANGE}"
    return None if math.isnan(value) else rule.violation(value)


def as_text(change: Any) -> Any:
    """A change with text for a number."""
    return str(change) if isinstance(change, Real) and not isinstance(change, bool) else change


def dotted_items(changes: Mapping[Any, Any], paths: Mapping[str, Rule], outer: str = "") -> Iterator[tuple[str, Any]]:
    """The keys of mappings in mappings with dots, down to one of the `paths`, and their values."""
    for name, change in changes.items():
        key = f"{outer}{name}"
        if isinstance(change, dict) and change and key not in paths:
            yield from dotted_items(change, paths, f"{key}.")
        else:
            yield key, change


def dotted(changes: Any, paths: Mapping[str, Rule]) -> Any:
    """Changes by dotted keys, without those that are None; what is no mapping stays as it is."""
    if not isinstance(changes, dict):
        return changes
    return {key: as_text(change) for key, change in dotted_items(changes, paths) if change is not None}
