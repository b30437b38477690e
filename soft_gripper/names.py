"""Names of fingers, models and phases: they become names of blocks, signals, files and axes of recordings."""

import re

NAME_RULE = "give a name of up to 60 letters (a to z), digits, _ and -, a letter first"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}")


def is_name(text: str) -> bool:
    """Whether a text can name a part of a scenario."""
    return _NAME.fullmatch(text) is not None
