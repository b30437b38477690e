"""Contact forces as arrows and the uncertainty of a curve as a band, drawn in the bending plane in mm."""

from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, Polygon

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.estimate_shapes import point_at
from soft_gripper.estimators.contact_levers import face_offset
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain
from soft_gripper.pictures.finger_shapes import in_mm
from soft_gripper.shape.arcs import Arcs

TRUE_COLOR, ESTIMATED_COLOR, BAND_COLOR = "#731a80", "#e09f00", "#009999"  # as in Meshcat, darker on white
STDS = 2  # standard deviations, on either side
_LENGTH = 0.025  # m for a newton
_LEAST = 0.02  # N, that is drawn


class Arrow(NamedTuple):
    """A force on a finger: from the face that it presses on to where it pushes, m in B."""

    begin: complex
    end: complex


def arrow_of_force(finger: Finger, point: complex, heading: float, force: float, arc_length: float) -> Arrow | None:
    """The arrow of a force across the finger; None where it is not known, or next to none.

    Args:
        finger: that is pressed.
        point: of its axis at `arc_length` m, z + i x, m in B.
        heading: of the axis there, rad.
        force: N, positive on the inner side.
        arc_length: m.
    """
    if not abs(force) >= _LEAST or not np.isfinite([point.real, heading, arc_length]).all():
        return None
    normal = 1j * np.exp(1j * heading)
    begin = point + float(face_offset(finger, np.array(arc_length), np.array(force))) * normal
    return Arrow(complex(begin), complex(begin - _LENGTH * force * normal))


def point_on_chain(finger: Finger, chain: Chain, s: float) -> tuple[complex, float]:
    """The point at arc length s, m, of a chain of rigid links, z + i x in B, and the heading of its link, rad."""
    link = int(np.searchsorted(finger.joint_arc_lengths, s))
    begin, heading = np.concatenate([[0], chain.joints])[link], float(chain.headings[link])
    return complex(begin + (s - finger.link_ends[link]) * np.exp(1j * heading)), heading


def draw_force(axes: Axes, arrow: Arrow, color: str, label: str, width: float = 1.4) -> None:
    """An arrow with its name for the legend; a narrower one lies over a wider one."""
    begin, end = (tuple(in_mm(np.array(point))) for point in arrow)
    look: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 6 * width, "shrinkA": 0, "shrinkB": 0}
    axes.add_patch(FancyArrowPatch(begin, end, color=color, lw=width, zorder=5 + 1 / width, **look))
    axes.plot([], [], color=color, lw=width, marker=">", ms=4, label=label)


def draw_band(axes: Axes, finger: Finger, arcs: Arcs, std: Array) -> None:
    """Two standard deviations on either side of the curve, from those of joints and tip, (N + 1) m."""
    points, headings = (np.array(part) for part in zip(*(point_at(arcs, s) for s in finger.link_ends), strict=True))
    aside = STDS * np.concatenate([[0.0], std]) * 1j * np.exp(1j * headings)
    outline = in_mm(np.concatenate([points + aside, (points - aside)[::-1]]))
    axes.add_patch(
        Polygon(outline, facecolor=BAND_COLOR, alpha=0.45, lw=0, zorder=4, label=f"± {STDS} standard deviations")
    )
    axes.plot(*in_mm(points).T, color="black", lw=0.8, zorder=4)
