"""ObjectWidth: how wide the object is that the fingers of a gripper hold, from their estimated shapes.

Width and gripper opening are one measure, twice the mean distance of points from their centroid. For two points that
is their distance, so two fingers are not a special case.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import link_directions
from soft_gripper.load.gripper_opening import Gripper, spread

_POINTS = 4  # on the inner surface, for every segment
_ROUNDS = 4  # over all fingers, in which the narrowest place is looked for


@dataclass(frozen=True)
class InnerSurface:
    """Points along the inner side of a finger, a few for every segment, from the base to the edge at the tip."""

    finger: Finger

    @cached_property
    def levers(self) -> Planar:
        """How far the direction of each link, and its inner normal, carry each point, m, (N + 1, M)."""
        finger, ends = self.finger, self.finger.link_ends
        s = np.linspace(0.0, finger.length, _POINTS * finger.segments + 1)
        along = np.clip(s - ends[:-1, None], 0.0, np.diff(ends)[:, None])
        own_link = np.searchsorted(ends[1:-1], s) == np.arange(finger.segments + 1)[:, None]
        levers: Planar = along + 1j * own_link * finger.section(s).inner_face
        return levers

    def points(self, q: Array) -> Planar:
        """The points at joint angles (..., N) rad, m in B, (..., M)."""
        points: Planar = self.levers[0] + link_directions(q) @ self.levers[1:]
        return points


def narrowest(curves: Sequence[Array]) -> float:
    """The smallest spread of points, one of each curve, (M, 3) m each; m.

    Compares all pairs of two curves. Of more it looks at points that lie equally far along them, and from the best of
    these moves one point at a time.
    """
    if len(curves) == 2:
        apart = curves[0][:, None] - curves[1]
        return float(np.sqrt(np.add.reduce(apart**2, axis=-1).min()))
    along = np.linspace(0.0, 1.0, max(map(len, curves)))
    points = np.stack([curve[np.round(along * (len(curve) - 1)).astype(int)] for curve in curves], axis=1)
    found = points[np.argmin(spread(points))]
    for _ in range(_ROUNDS):
        for i, curve in enumerate(curves):
            choices = np.repeat(found[None], len(curve), axis=0)
            choices[:, i] = curve
            found = choices[np.argmin(spread(choices))]
    return float(spread(found))


class ObjectWidth(ArrayBlock):
    """Measures what the fingers of one palm hold between them.

    ::

        {finger}.estimated_joint_angles (N) rad ---> +-------------+
        {finger}.contact (1) 0 or 1 ---------------> | ObjectWidth | ---> object_width  (1) m, NaN unless all touch
                                                     +-------------+

    The width is the smallest spread (see `gripper_opening`) of points on the inner surfaces, one of each finger: for
    two fingers the smallest gap, for more the diameter of what they close on. It is that of an object that they hold
    by its widest place, as tips hold a box. Where the bases stand to each other is part of the gripper and does not
    change. Skin that gives way is not allowed for, since how much depends on where and how the object is touched.
    """

    def __init__(self, gripper: Gripper, fingers: Mapping[str, Finger]):
        """`fingers` are those of the gripper, in its order, by the names of their ports."""
        super().__init__()
        self._gripper, self._surfaces = gripper, [InnerSurface(finger) for finger in fingers.values()]
        angles, contacts = ([f"{name}.{kind}" for name in fingers] for kind in (ANGLES, "contact"))
        for name, finger in zip(angles, fingers.values(), strict=True):
            self.take(name, finger.segments)
        for name in contacts:
            self.take(name, 1)
        self.put_out("object_width", self._width, *angles, *contacts, unit="m")

    def _width(self, *inputs: Array) -> Array:
        """From the joint angles of all fingers, (..., N) rad, and then their contacts, (..., 1); (...) m."""
        count = len(self._surfaces)
        angles, contacts = inputs[:count], np.concatenate(inputs[count:], axis=-1)
        is_held = contacts.all(axis=-1) & np.logical_and.reduce([np.isfinite(q).all(axis=-1) for q in angles])
        held = (surface.points(q[is_held]) for surface, q in zip(self._surfaces, angles, strict=True))
        curves = [self._gripper.curve(i, points) for i, points in enumerate(held)]
        width = np.full(is_held.shape, np.nan)
        width[is_held] = [narrowest(of_sample) for of_sample in zip(*curves, strict=True)]
        return width
