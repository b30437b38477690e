"""Extras: additions to the core, each a folder whose README names its readers, or a file.

The core names none of them, and goes on without any. An extra is found by its place: `commands` in its folder, or the
file, declares its commands, if it has any, and imports neither Drake nor numpy outside of functions.
`soft_gripper.extras.NAME` is loaded when it is used.
"""

import pkgutil
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


def names() -> list[str]:
    """Names of the installed extras."""
    return sorted(module.name for module in pkgutil.iter_modules(__path__))


def command_modules() -> list[Any]:
    """The modules that declare the commands of extras; other folders are not imported, since that takes long."""
    folders = (extra for extra in names() if Path(__path__[0], extra, "commands", "__init__.py").is_file())
    file_names = (entry.name for entry in pkgutil.iter_modules(__path__) if not entry.ispkg)
    return [
        import_module(f"{__name__}.{module}") for module in (*(f"{extra}.commands" for extra in folders), *file_names)
    ]


def added(name: str) -> list[Any]:
    """Collects the additions of extras to the core under a name in their modules `adds`; see docs/howto/own_extra.md.

    These modules are imported whenever a scenario is read, after the packages that they are in: both import nothing
    that takes long, or that an installation may lack.
    """
    modules = (import_module(f"{__name__}.{extra}.adds") for extra in _extras_with_adds())
    return [getattr(module, name) for module in modules if hasattr(module, name)]


@cache  # looking for files takes 1 ms, and every run of a sweep asks several times
def _extras_with_adds() -> tuple[str, ...]:
    return tuple(extra for extra in names() if Path(__path__[0], extra, "adds.py").is_file())


__all__ = names()


def __getattr__(name: str) -> ModuleType:
    if name not in names():
        raise AttributeError(f"there is no extra '{name}'; known: {', '.join(names())}")
    return import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    return [*names(), "added", "command_modules", "names"]
