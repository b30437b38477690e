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


def parts(part: str) -> list[Any]:
    """Modules of one name, of all extras that have it; others are not imported."""
    folders = {extra: Path(__path__[0], extra) for extra in names()}
    have = (extra for extra, folder in folders.items() if (folder / part).is_dir() or (folder / f"{part}.py").is_file())
    return [import_module(f"{__name__}.{extra}.{part}") for extra in have]


__all__ = names()


def __getattr__(name: str) -> ModuleType:
    if name not in names():
        raise AttributeError(f"there is no extra '{name}'; known: {', '.join(names())}")
    return import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    return [*names(), "names", "parts"]
