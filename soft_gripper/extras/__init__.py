"""Extras: what stands beside the core, a folder each, with a README that says for whom.

The core names none of them, and goes on without any. An extra is found by its folder: `commands` in it declares its
commands, if it has any, and imports neither Drake nor numpy. `soft_gripper.extras.NAME` is loaded when it is used.
"""

import pkgutil
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


def names() -> list[str]:
    """Names of the extras that are there."""
    return sorted(found.name for found in pkgutil.iter_modules(__path__))


def command_modules() -> list[Any]:
    """The modules `commands` of all extras that have one; those without are not imported, since that takes long."""
    having = (extra for extra in names() if Path(__path__[0], extra, "commands").is_dir())
    return [import_module(f"{__name__}.{extra}.commands") for extra in having]


__all__ = names()


def __getattr__(name: str) -> ModuleType:
    if name not in names():
        raise AttributeError(f"there is no extra '{name}'; known: {', '.join(names())}")
    return import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    return [*names(), "command_modules", "names"]
