"""A Meshcat, if there is a port for it."""

from pydrake.geometry import Meshcat, MeshcatParams

from soft_gripper.errors import InputError, first_line


def open_meshcat(host: str = "*") -> Meshcat:
    """A Meshcat at the first port that is free, of an address of this machine; "*" is all of them.

    Raises:
        InputError: if there is none.
    """
    try:
        return Meshcat(MeshcatParams(host=host))
    except RuntimeError as error:
        expected = f"none is free at {host}; end other viewers ({first_line(error)})"
        raise InputError("Meshcat", "port", "7000 to 7099", expected) from None
