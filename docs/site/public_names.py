"""The public names of the package, and what they stand for."""

import inspect
from functools import cache
from operator import attrgetter
from typing import Any

import soft_gripper as sg


@cache
def public_names() -> dict[str, list[str]]:
    """The public names by their namespaces, "" being that of `soft_gripper`; such as "fingers": ["fingers.Finger"]."""
    spaces = {"": sg} | {name: part for name in sg.__all__ if inspect.ismodule(part := getattr(sg, name))}
    spaces |= {f"extras.{name}": getattr(sg.extras, name) for name in spaces.pop("extras").__all__}
    return {
        space: [f"{space}.{name}".lstrip(".") for name in module.__all__ if not inspect.ismodule(getattr(module, name))]
        for space, module in spaces.items()
        if hasattr(module, "__all__")
    }


def public(name: str) -> Any:
    """What a public name stands for, such as "fingers.Finger"."""
    return attrgetter(name)(sg)
