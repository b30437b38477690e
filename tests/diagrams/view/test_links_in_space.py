"""Where the links of an estimate in space are, and the pieces that are drawn along them."""

import numpy as np
import pytest
from drawing import Drawing
from pydrake.multibody.tree import BodyIndex

from soft_gripper.diagrams.view.estimate_visualizer import (
    BAND,
    CONTACT,
    LENGTH,
    DrawnFinger,
    draw_arrow_in_space,
    draw_links,
    place_arrow,
    place_ribbon,
    widen_links,
)
from soft_gripper.diagrams.view.links_in_space import link_frames, pressed_point
from soft_gripper.fingers.finger import Finger

ARROW = f"{CONTACT}/finger/arrow"


def corners_of(finger: Finger, sideways: float = 0.0) -> np.ndarray:
    """A straight finger that leans by an angle toward +y, rad."""
    return finger.length * np.outer(
        np.append(0.0, [*finger.joint_arc_lengths, finger.length]) / finger.length,
        [0.0, np.sin(sideways), np.cos(sideways)],
    )


def test_frames_point_along_the_links_and_are_rotations() -> None:
    corners = np.random.default_rng(1).normal(size=(5, 14, 3))
    frames, along = link_frames(corners), np.diff(corners, axis=-2)
    np.testing.assert_allclose(
        frames @ np.swapaxes(frames, -1, -2), np.broadcast_to(np.eye(3), frames.shape), atol=1e-9
    )
    np.testing.assert_allclose(np.linalg.det(frames), 1)
    np.testing.assert_allclose(frames[..., 2] * np.linalg.norm(along, axis=-1, keepdims=True), along)
    assert np.all(frames[..., 0, 0] >= 0)


@pytest.mark.parametrize(
    ("side", "axis", "sign"), [(0.0, 0, 1), (np.pi, 0, -1), (np.pi / 2, 1, 1), (-np.pi / 2, 1, -1)]
)
def test_the_pressed_point_is_on_its_face(shipped_finger: Finger, side: float, axis: int, sign: int) -> None:
    section, s = shipped_finger.section(0.07), 0.07
    faces = {
        (0, 1): section.inner_face,
        (0, -1): section.outer_face,
        (1, 1): section.width / 2,
        (1, -1): -section.width / 2,
    }
    point = pressed_point(shipped_finger, corners_of(shipped_finger), s, side)
    assert point[2] == pytest.approx(s)
    assert point[axis] == pytest.approx(float(faces[axis, sign]), abs=1e-9)


def drawn(finger: Finger, force: np.ndarray, sideways: float = 0.3) -> Drawing:
    drawing = Drawing()
    shown = DrawnFinger("finger", finger, np.arange(13), BodyIndex(0), (), True, True, True)
    place_arrow(drawing, shown)  # type: ignore[arg-type]
    place_ribbon(drawing, shown)  # type: ignore[arg-type]
    corners = corners_of(finger, sideways)
    draw_arrow_in_space(drawing, shown, corners, force, 0.07, np.pi / 2, 0.1)  # type: ignore[arg-type]
    draw_links(drawing, f"{BAND}/finger", corners, 0.1)  # type: ignore[arg-type]
    widen_links(drawing, f"{BAND}/finger", np.full(13, 1e-3), 0.1)  # type: ignore[arg-type]
    return drawing


def test_the_arrow_is_the_force_where_the_surface_is_pressed(shipped_finger: Finger) -> None:
    force = np.array([0.2, -0.9, 0.3])
    seen = drawn(shipped_finger, force)
    begin = seen.in_world(f"{ARROW}/shaft/middle", [0, 0, -0.5])
    end = seen.in_world(f"{ARROW}/head/middle", [0, 0, 0])
    expected = pressed_point(shipped_finger, corners_of(shipped_finger, 0.3), 0.07, np.pi / 2)
    np.testing.assert_allclose(begin, expected, atol=3e-6)
    np.testing.assert_allclose(end - begin, LENGTH * force, atol=3e-6)


@pytest.mark.parametrize("force", [np.zeros(3), np.full(3, np.nan)])
def test_without_a_force_there_is_no_arrow(shipped_finger: Finger, force: np.ndarray) -> None:
    assert drawn(shipped_finger, force).properties[ARROW, "visible"] is False


def test_the_ribbon_lies_along_the_links(shipped_finger: Finger) -> None:
    """Two standard deviations to either side, across the leaning finger."""
    seen, corners = drawn(shipped_finger, np.zeros(3)), corners_of(shipped_finger, 0.3)
    for i in (0, 6, 12):
        middle = (corners[i] + corners[i + 1]) / 2
        np.testing.assert_allclose(seen.in_world(f"{BAND}/finger/{i}", [0, 0, 0]), middle, atol=1e-9)
        left, right = (seen.in_world(f"{BAND}/finger/{i}/left", [x, 0, 0]) for x in (-0.5, 0.5))
        wide = np.linalg.norm(right - left)
        assert wide == pytest.approx(2e-3 if i == 0 else 4e-3, abs=3e-6)
