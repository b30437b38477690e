"""Poses of what is drawn in the bending plane of a finger, in few digits."""

from pydrake.geometry import Meshcat

_STEPS = 2.0**20  # in a metre and in a radian: numbers of few digits, which a replay keeps in little room


def put(meshcat: Meshcat, path: str, position: complex, heading: float, time: float) -> None:
    """Poses an object in the frame above it, z + i x in m and rad from z to x.

    In a recording this takes less room than a transform.
    """
    x, z, angle = (rounded(value) for value in (position.imag, position.real, heading))
    meshcat.SetProperty(path, "position", [x, 0.0, z], time)
    meshcat.SetProperty(path, "rotation[y]", angle, time)


def rounded(value: float) -> float:
    """A length, m, or an angle, rad, to about a millionth."""
    return round(float(value) * _STEPS) / _STEPS
