"""Objects by name: those of this project, which are registered, and those that a user has written.

A user's own is named "module:function", and imported from Python's path and the current folder, or "file.py:function",
wherever the file is: not from the folder of a scenario, so that an untrusted scenario cannot bring its own code.
Sensors, estimators, measures, and the ends of a bench are all found here; whatever a user's module or function raises
becomes one line that names the field and the function.
"""

import importlib
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import Any

from pydrake.systems.framework import System

from soft_gripper.errors import InputError, described

_IN_USE = "_soft_gripper_in_use"  # attribute of a block that is part of a diagram


def is_own(name: str) -> bool:
    """Whether a name is that of a user's function."""
    return ":" in name


def module_of(name: str) -> str:
    """The name that the module of a user's function has in Python."""
    module = name.rpartition(":")[0]
    return str(Path(module).expanduser().resolve()) if module.endswith(".py") else module


def label(name: str) -> str:
    """The name of an estimator in the names of signals, which have no folders."""
    module, colon, function = name.rpartition(":")
    return f"{Path(module).stem}:{function}" if colon and module.endswith(".py") else name


def find_function(field: str, name: str) -> Callable[..., Any]:
    """A user's function that an option or a field names.

    Raises:
        InputError: if it cannot be imported, or is not callable.
    """
    if not is_own(name):
        raise InputError("scenario", field, name, 'give "module:function"')
    found: Callable[..., Any] = find_named(field, name, {})
    return found


def find_named(field: str, name: str, known: Mapping[str, Any]) -> Any:
    """One of the `known`, or a user's own; `field` is the field or option that names it.

    Raises:
        InputError: if it does not exist.
    """
    if name in known:
        return known[name]
    module, _, function = name.rpartition(":")
    if not module or not function:
        raise InputError("scenario", field, name, f'known: {", ".join(known)}; or give "module:function" of your own')
    try:
        found = getattr(_imported(module), function)
    except (Exception, SystemExit) as error:  # whatever a user's module may raise
        where = "" if module.endswith(".py") else f"; looked where Python looks, and in {Path.cwd()}"
        raise InputError("scenario", field, name, f"cannot be imported: {described(error)}{where}") from error
    if not callable(found):
        raise InputError("scenario", field, name, "is not callable")
    return found


def made(field: str, name: str, make: Callable[..., Any], *arguments: Any) -> Any:
    """Calls a function, which may be a user's own.

    Raises:
        InputError: if it fails.
    """
    with seen_from(field, name), blamed_on("scenario", field, name):
        return make(*arguments)


@contextmanager
def blamed_on(where: object, field: str, name: str) -> Iterator[None]:
    """Any failure inside becomes an InputError that names the user's function."""
    try:
        yield
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # whatever a user's function may raise
        raise InputError(where, field, name, f"failed: {described(error)}") from error


@contextmanager
def seen_from(field: str, name: str) -> Iterator[None]:
    """An InputError about a user's own block names the function that made it."""
    try:
        yield
    except InputError as error:
        if not is_own(name):
            raise
        raise error.inside(f"{field} = {name}") from error.__cause__


def make_block(field: str, name: str, make: Callable[..., System], *arguments: Any) -> System:
    """The block that a function makes from its arguments.

    Args:
        field: the scenario field or option that names the function.
        name: a built-in block, or a user's own, see `name_of`.
        make: the function.
        arguments: its arguments.

    Raises:
        InputError: if it fails, does not return a system, or returns a block that it returned before.
    """
    block = made(field, name, make, *arguments)
    if not isinstance(block, System):
        raise InputError("scenario", field, name, f"returned {type(block).__name__}; return a Drake System")
    if hasattr(block, _IN_USE):
        raise InputError("scenario", field, name, "returned the same block twice; make a new one for each finger")
    setattr(block, _IN_USE, True)
    return block


def name_of(make: Callable[..., System] | None, type_name: str) -> str:
    """The name of a block in tables, recordings and messages: a user's function, or the type in the scenario."""
    return type_name if make is None else f"{make.__module__}:{getattr(make, '__qualname__', repr(make))}"


def _imported(module: str) -> ModuleType:
    """A module by its name, for which the current folder is searched last, or by its file."""
    if module.endswith(".py"):
        return _imported_file(module_of(f"{module}:"))
    here = str(Path.cwd())
    sys.path.append(here)
    try:
        return importlib.import_module(module)
    finally:
        sys.path.remove(here)


def _imported_file(file: str) -> ModuleType:
    """The module in a file, which is run once."""
    if file not in sys.modules:
        sys.modules[file] = module = ModuleType(file)
        module.__file__ = file
        try:
            SourceFileLoader(file, file).exec_module(module)
        except BaseException:
            del sys.modules[file]
            raise
    return sys.modules[file]
