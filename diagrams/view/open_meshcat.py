"""A Meshcat, if there is a port for it."""

from pydrake.geometry import Meshcat

from soft_gripper.errors import InputError, first_line


def open_meshcat() -> Meshcat:
    """A Meshcat at the first port that is free.

    Raises:
        InputError: if there is none.
    """
    try:
        return Meshcat()
    except RuntimeError as error:
        raise InputError(
            "Meshcat", "port", "7000 to 7099", f"none is free; end other viewers ({first_line(error)})"
        ) from None
