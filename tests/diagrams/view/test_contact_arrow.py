"""The arrow of an estimated contact: where it begins, where it points, how long it is, and when it is hidden."""

import numpy as np
import pytest
from drawing import Drawing
from pydrake.multibody.tree import BodyIndex

from soft_gripper.diagrams.view.estimate_visualizer import CONTACT, DrawnFinger, draw_arrow, place_arrow
from soft_gripper.diagrams.view.finger_drawing import LENGTH, estimated_contact, estimated_corners
from soft_gripper.fingers.finger import Finger

PATH = f"{CONTACT}/finger/arrow"
ROUNDING = 3e-6  # m


def drawn(finger: Finger, force: float, arc_length: float, lean: float = 0.4) -> Drawing:
    """Of a finger that leans by an angle, rad."""
    drawing, along = Drawing(), np.outer(finger.link_ends[1:], [np.sin(lean), np.cos(lean)])
    signals = {"joint_positions": along[:-1], "tip_pose": np.array([*along[-1], lean])}
    corners = estimated_corners(signals)
    contact = {"contact_force": np.array([force]), "contact_arc_length": np.array([arc_length])}
    shown = DrawnFinger("finger", finger, 2, BodyIndex(0), (), {})
    place_arrow(drawing, shown)  # type: ignore[arg-type]
    draw_arrow(drawing, shown, corners, estimated_contact(contact, corners), 0.1)  # type: ignore[arg-type]
    return drawing


def ends(drawing: Drawing, side: str) -> np.ndarray:
    """Where the shaft begins and the head ends, (2, 3) m in B; the cone's own point is its origin."""
    begin = drawing.in_world(f"{PATH}/shaft/{side}", [0, 0, -0.5])
    return np.array([begin, drawing.in_world(f"{PATH}/head/{side}", [0, 0, 0])])


@pytest.mark.parametrize("force", [0.8, -1.3])
@pytest.mark.parametrize("s", [0.02, 0.1])
def test_begins_at_the_face_and_points_into_the_finger(shipped_finger: Finger, force: float, s: float) -> None:
    """A force that presses on the inner side pushes outward."""
    place, normal = s * np.array([np.sin(0.4), np.cos(0.4)]), np.array([np.cos(0.4), -np.sin(0.4)])
    section = shipped_finger.section(s)
    face = float(section.inner_face if force > 0 else section.outer_face)
    seen = drawn(shipped_finger, force, s)
    for side, sign in (("left", 1), ("right", -1)):
        begin, end = ends(seen, side)
        np.testing.assert_allclose(begin[::2], place + face * normal, atol=ROUNDING)
        np.testing.assert_allclose((end - begin)[::2], -LENGTH * force * normal, atol=2 * ROUNDING)
        assert np.all(sign * np.array([begin[1], end[1]]) > shipped_finger.base.width / 2), "beside the finger"
    assert seen.properties[PATH, "visible"] is True


@pytest.mark.parametrize(
    ("force", "arc_length", "lean"),
    [(0.0, np.nan, 0.4), (np.nan, np.nan, 0.4), (0.01, 0.06, 0.4), (1.0, np.nan, 0.4), (1.0, 0.06, np.nan)],
)
def test_is_hidden_where_there_is_no_contact(
    shipped_finger: Finger, force: float, arc_length: float, lean: float
) -> None:
    seen = drawn(shipped_finger, force, arc_length, lean)
    assert seen.properties[PATH, "visible"] is False
    assert np.isfinite(
        np.hstack([value for (_, name), value in seen.properties.items() if name != "visible"] + [0])
    ).all()
