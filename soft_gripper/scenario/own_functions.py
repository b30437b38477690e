"""Functions and classes by name: those of this project, and users' own as "module:function"."""

import importlib
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from soft_gripper.errors import InputError, described


def is_own(name: str) -> bool:
    """Whether a name is of the form "module:function"."""
    return ":" in name


def find_function(field: str, name: str) -> Callable[..., Any]:
    """A user's function, "module:function", that an option or a field names.

    Raises:
        InputError: if it cannot be imported, or is not callable.
    """
    if not is_own(name):
        raise InputError("scenario", field, name, 'give "module:function"')
    found: Callable[..., Any] = find_named(field, name, {})
    return found


def find_named(field: str, name: str, known: Mapping[str, Any]) -> Any:
    """One of the `known`, or a user's own "module:function"; `field` is the field or option that names it.

    Raises:
        InputError: if it does not exist.
    """
    if name in known:
        return known[name]
    module, colon, function = name.partition(":")
    if not colon or not module or not function:
        raise InputError("scenario", field, name, f'known: {", ".join(known)}; or give "module:function" of your own')
    try:
        made = getattr(_import(module), function)
    except (Exception, SystemExit) as error:  # whatever a user's module may raise
        where = f"looked where Python looks, and in {Path.cwd()}"
        raise InputError("scenario", field, name, f"cannot be imported: {described(error)}; {where}") from error
    if not callable(made):
        raise InputError("scenario", field, name, "is not callable")
    return made


def made(field: str, name: str, make: Callable[..., Any], *arguments: Any) -> Any:
    """Calls a function, which may be a user's own.

    Raises:
        InputError: if it fails.
    """
    with seen_from(field, name):
        try:
            return make(*arguments)
        except InputError:
            raise
        except (Exception, SystemExit) as error:  # whatever a user's function may raise
            raise InputError("scenario", field, name, f"failed: {described(error)}") from error


@contextmanager
def seen_from(field: str, name: str) -> Iterator[None]:
    """An InputError about a user's own block names the function that made it."""
    try:
        yield
    except InputError as error:
        if not is_own(name):
            raise
        raise error.inside(f"{field} = {name}") from error.__cause__


def _import(module: str) -> Any:
    """A module; the current folder is searched last."""
    here = str(Path.cwd())
    sys.path.append(here)
    try:
        return importlib.import_module(module)
    finally:
        sys.path.remove(here)
