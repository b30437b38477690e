"""Registries: what is registered under a name by this project, by an extra, or named by a user who wrote it.

A user's own is named "module:function", and imported from Python's path and the current folder, or "file.py:function",
wherever the file is: not from the folder of a scenario, so that an untrusted scenario cannot bring its own code.
Sensors, estimators, measures, the ends of a bench, and what extras add are all found here. Whatever a user's module or
function raises becomes one line that names the field and the function.
"""

import importlib
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from copy import copy
from dataclasses import fields
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, TypeVar

from soft_gripper.errors import InputError, described, is_near, suggestion
from soft_gripper.extras import added

if TYPE_CHECKING:  # commands are declared without Drake
    from pydrake.systems.framework import System

_T = TypeVar("_T")
_Class = TypeVar("_Class", bound=type)
_IN_USE = "_soft_gripper_in_use"  # attribute of a block that is part of a diagram


class Registry(dict[str, _T]):
    """Names of a kind that this project registers; a user's own is found beside them."""

    def __init__(self, field: str, registered_values: Mapping[str, _T] = MappingProxyType({})):
        """`field` is the field of a scenario, or the option of a command, that gives a name."""
        super().__init__(registered_values)
        self._field = field

    def find(self, name: str, field: str | None = None, where: object = "scenario") -> _T:
        """The value that is registered under a name, or a user's own; raises an InputError if none can be called.

        `field` gives the name, if it is not that of the registry, in the file or command `where`.
        """
        if name in self:
            return self[name]
        field = field or self._field
        module, _, function = name.rpartition(":")
        if not module or not function:
            own_form = 'give "module:function" of your own'
            raise InputError(where, field, name, f"{suggestion(name, self)} (or {own_form})" if self else own_form)
        try:
            function_or_class: _T = _find_named(name)
        except (Exception, SystemExit) as error:  # whatever a user's module may raise
            hint = _search_hint(module) if isinstance(error, ModuleNotFoundError | FileNotFoundError) else ""
            raise InputError(where, field, name, f"cannot be imported: {described(error)}{hint}") from error
        if not callable(function_or_class):
            raise InputError(where, field, name, "is not callable")
        return function_or_class


def _search_hint(module: str) -> str:
    """Hint on the searched places of a missing module, and on a similar file there."""
    path = Path(module).expanduser()
    if module.endswith(".py"):
        return _nearest(path.name, [file.name for file in path.parent.glob("*.py")])
    similar_file = _nearest(module, [file.stem for file in Path.cwd().glob("*.py")])
    return f"; looked where Python looks, and in {Path.cwd()}{similar_file}"


OWN = Registry[Callable[..., Any]]("function")  # where nothing is registered: a user's own alone


def registered(kind: str) -> dict[str, Callable[..., Any]]:
    """Functions that extras register under a kind, by name; each is imported when it is called.

    An extra declares it in its module `adds` as {name: "module:function"}, see docs/howto/own_extra.md.
    """
    functions: dict[str, Callable[..., Any]] = {}
    for additions in added(kind):
        for name, text in additions.items():
            functions[name] = lambda *arguments, text=text: _find_named(text)(*arguments)
    return functions


def with_added_fields(cls: _Class) -> _Class:
    """A class of the schema, before it becomes a dataclass, with the fields that extras add to it in `FIELDS`."""
    for additions in added("FIELDS"):
        for field in fields(additions[cls.__name__]) if cls.__name__ in additions else ():
            cls.__annotations__[field.name] = field.type
            setattr(cls, field.name, copy(field))
    return cls


def is_own(name: str) -> bool:
    return ":" in name


def module_of(name: str) -> str:
    """The name that the module of a user's function has in Python."""
    module = name.rpartition(":")[0]
    return str(Path(module).expanduser().resolve()) if module.endswith(".py") else module


def label(name: str) -> str:
    """The name of an estimator in the names of signals, which have no folders."""
    module, colon, function = name.rpartition(":")
    return f"{Path(module).stem}:{function}" if colon and module.endswith(".py") else name


def name_of(make: Callable[..., "System"] | None, type_name: str) -> str:
    """The name of a block in tables, recordings and messages: a user's function, or the type in the scenario."""
    return type_name if make is None else f"{make.__module__}:{getattr(make, '__qualname__', repr(make))}"


@contextmanager
def blamed_on(field: str, name: str, where: object = "scenario") -> Iterator[None]:
    """A failure of a user's function inside becomes an InputError that names it; one about its block names it too.

    `field` names the function in the file or command `where`. Failures of this project's own are left as they are.
    """
    try:
        yield
    except InputError as error:
        if not is_own(name):
            raise
        raise error.inside(f"{field} = {name}") from error.__cause__
    except (Exception, SystemExit) as error:  # whatever a user's function may raise
        if not is_own(name):
            raise
        raise InputError(where, field, name, f"failed: {described(error)}") from error


def make_block(field: str, name: str, make: Callable[..., "System"], *arguments: Any) -> "System":
    """The block that a function makes from its arguments; `field` gives its name, see `name_of`.

    Raises an InputError if it fails, does not return a system, or returns a block that it returned before.
    """
    from pydrake.systems.framework import System

    with blamed_on(field, name):
        block = make(*arguments)
    if not isinstance(block, System):
        raise InputError("scenario", field, name, f"returned {type(block).__name__}; return a Drake System")
    if hasattr(block, _IN_USE):
        raise InputError("scenario", field, name, "returned the same block twice; make a new one for each finger")
    setattr(block, _IN_USE, True)
    return block


def _find_named(name: str) -> Any:
    module, function = _import_module(module_of(name)), name.rpartition(":")[2]
    try:
        return getattr(module, function)
    except AttributeError as error:
        raise AttributeError(f"{error}{_nearest(function, vars(module))}") from None


def _nearest(name: str, valid_names: Iterable[str]) -> str:
    """A hint for a name that is most likely mistyped."""
    return f"; {suggestion(name, valid_names)}" if is_near(name, valid_names) else ""


def _import_module(name: str) -> ModuleType:
    """Imports a module by its name, with the current folder searched last, or by its file, which is run once."""
    if name.endswith(".py") and name not in sys.modules:
        sys.modules[name] = module = ModuleType(name)
        module.__file__ = name
        try:
            SourceFileLoader(name, name).exec_module(module)
        except BaseException:
            del sys.modules[name]
            raise
    if name in sys.modules:
        return sys.modules[name]
    folder = str(Path.cwd())
    sys.path.append(folder)
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(folder)
