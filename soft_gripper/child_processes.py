"""The environment of child processes."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

SAFE_PATH = {"PYTHONSAFEPATH": "1"}  # `python -c` would search the current folder first for Python's own modules


@contextmanager
def environment(variables: dict[str, str]) -> Iterator[None]:
    """Sets variables of the environment for child processes that are started within the block."""
    old_values = {name: os.environ.get(name) for name in variables}
    os.environ.update(variables)
    try:
        yield
    finally:
        for name, value in old_values.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value
