"""DrawnFinger: the fixed properties of a finger whose estimate is drawn."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Meshcat
from pydrake.multibody.tree import BodyIndex

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger

PROUD = 1e-3  # m, how far the estimate protrudes from the sides of the finger
_PIECES = 2  # of the curve, for every segment


@dataclass(frozen=True, eq=False)
class DrawnFinger:
    """A finger whose estimate is drawn."""

    name: str
    finger: Finger
    section_ends: NDArray[np.int_]  # segments covered up to the end of each arc of the estimated curve, from 0 to N
    base: BodyIndex  # body whose frame is B
    skin: tuple[tuple[str, ...], ...]  # Meshcat paths of the shapes of every link, base to tip
    has_contact: bool = False  # a contact force is estimated
    has_band: bool = False  # the uncertainty of the curve is estimated

    @property
    def sections(self) -> int:
        """Number of arcs of the estimated curve."""
        return len(self.section_ends) - 1

    @property
    def pieces(self) -> int:
        """Number of pieces that each arc of the curve is drawn in."""
        return int(np.ceil(_PIECES * self.finger.segments / self.sections))

    @property
    def piece_lengths(self) -> Array:
        """Length of every piece, m."""
        sections = np.diff(self.section_ends) * self.finger.segment_length
        return np.repeat(sections / self.pieces, self.pieces)

    @property
    def sides(self) -> tuple[float, float]:
        """Distances from the bending plane between which the estimate is drawn on both sides, m.

        Between the sides there is nothing: the curve runs close below the inner face and would hide it.
        """
        widths = self.finger.base.width, self.finger.tip.width
        return min(widths) / 2 - PROUD, max(widths) / 2 + PROUD


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
