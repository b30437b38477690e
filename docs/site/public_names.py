"""The public names of the package, and what they stand for."""

import inspect
from functools import cache
from operator import attrgetter
from typing import Any

import soft_gripper as sg


@cache
def public_names() -> dict[str, list[str]]:
    """The public names by their namespaces, "" being that of `soft_gripper`; such as "fingers": ["fingers.Finger"]."""
    spaces = {"": sg} | {name: getattr(sg, name) for name in sg.__all__ if inspect.ismodule(getattr(sg, name))}
    return {
        space: [f"{space}.{name}".lstrip(".") for name in module.__all__ if name not in spaces]
        for space, module in spaces.items()
    }


def public(name: str) -> Any:
    """What a public name stands for, such as "fingers.Finger"."""
    return attrgetter(name)(sg)
