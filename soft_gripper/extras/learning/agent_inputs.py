"""Checks of an agent's inputs: actions, seeds and options, and the order of its calls.

SoftGripperEnv and SoftGripperVectorEnv share them, and their error messages.
"""

from collections.abc import Mapping, Sequence
from operator import index
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.errors import InputError

_LARGEST_SEED = 2**64 - 1  # of Drake's generator


def check_order(act: str, is_begun: bool, is_closed: bool) -> None:
    """Raises an InputError if an environment is closed, or was not reset before an act that requires it."""
    if is_closed:
        raise InputError(act, "environment", "closed", "make another one")
    if not is_begun:
        raise InputError(act, "environment", "not begun", "call reset() first")


def check_rendered(mode: str | None, modes: Sequence[str]) -> None:
    """Raises an InputError if an environment was made without one of its modes."""
    if mode not in modes:
        expected = f"make the environment with one of {', '.join(modes)}" if modes else "this environment has none"
        raise InputError("render", "render_mode", mode, expected)


def finite_actions(actions: Any, field: str, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Converts actions of a shape to numbers.

    Raises:
        InputError: if they are not numbers, not finite, or of another shape.
    """
    try:
        array = np.asarray(actions)
        numbers = array.astype(float) if array.dtype.kind in "biufO" else None
    except (TypeError, ValueError, OverflowError):  # ragged, not numbers, or too large
        numbers = None
    if numbers is None or numbers.shape != shape or not np.isfinite(numbers).all():
        raise InputError("step", field, actions, f"give finite numbers of shape {shape}, from -1 to 1")
    return numbers


def integer_seed(seed: Any, following: int = 0) -> int | None:
    """Converts a seed, also of numpy, to an integer with room for `following` more; None stays None.

    Raises:
        InputError: if it is not an integer, or one of them is below 0 or above 2^64 - 1.
    """
    try:
        number = None if seed is None else index(seed)
    except TypeError:
        number = -1
    if number is not None and not 0 <= number <= _LARGEST_SEED - following:
        raise InputError("reset", "seed", seed, "give an integer from 0 to 2^64 - 1, or None")
    return number


def integer_seeds(seeds: Any, count: int) -> list[int | None]:
    """Seeds of `count` environments: those of a list or array, or integers counted on from a single one.

    Raises:
        InputError: if one is not a seed, or the number of seeds is not that of environments.
    """
    is_list = seeds.ndim > 0 if isinstance(seeds, np.ndarray) else isinstance(seeds, Sequence)
    if is_list and not isinstance(seeds, str | bytes):
        if len(seeds) != count:
            raise InputError("reset", "seed", seeds, f"give {count}, one per environment")
        return [integer_seed(seed) for seed in seeds]
    first = integer_seed(seeds, following=count - 1)
    return [None if first is None else first + i for i in range(count)]


def check_options(options: Any) -> None:
    """Raises an InputError if a reset is given options."""
    if not (options is None or (isinstance(options, Mapping) and not options)):
        raise InputError("reset", "options", options, "there are none: leave them out")
