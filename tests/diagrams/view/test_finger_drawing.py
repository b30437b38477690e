"""Drawn fingers: links, bands, arrows of contacts, colours of torques."""

import numpy as np
import pytest
from drawing import Drawing
from pydrake.multibody.tree import BodyIndex

from soft_gripper.diagrams.view.estimate_visualizer import (
    BAND,
    CONTACT,
    DrawnFinger,
    draw_arrow,
    draw_links,
    place_arrow,
    place_ribbon,
    widen_ribbon,
)
from soft_gripper.diagrams.view.finger_drawing import (
    BAND_SIGNAL,
    CONTACTS,
    LENGTH,
    SHAPES,
    Contact,
    drawn_signals,
    estimated_contact,
    estimated_corners,
    points_on_links,
    pressed_point,
    to_world,
)
from soft_gripper.diagrams.view.torque_colors import color, round_limit
from soft_gripper.fingers.finger import Finger

ARROW = f"{CONTACT}/finger/arrow"


def corners_of(finger: Finger, sideways: float = 0.0) -> np.ndarray:
    """A straight finger that leans by an angle toward +y, rad."""
    return finger.length * np.outer(
        np.append(0.0, [*finger.joint_arc_lengths, finger.length]) / finger.length,
        [0.0, np.sin(sideways), np.cos(sideways)],
    )


def test_a_shape_in_space_is_drawn_where_it_is_estimated() -> None:
    planar = [*SHAPES[0], *SHAPES[1], *CONTACTS[0], *CONTACTS[1], BAND_SIGNAL, "theta"]
    known = [*planar, "estimated_sideways_angles"]
    assert drawn_signals(known) == [*SHAPES[0], *CONTACTS[0], BAND_SIGNAL]
    assert drawn_signals(planar) == [*SHAPES[1], *CONTACTS[1], BAND_SIGNAL]
    assert drawn_signals([*SHAPES[1], *CONTACTS[1]]) == [*SHAPES[1], *CONTACTS[1]]
    assert drawn_signals([*SHAPES[0][:1], "estimated_sideways_angles", BAND_SIGNAL]) == []


def test_many_samples_are_drawn_as_one() -> None:
    random = np.random.default_rng(2)
    joints, tips = random.normal(size=(7, 4, 2)), random.normal(size=(7, 3))
    force, s = random.normal(size=7), random.uniform(0, 2, 7)
    signals = {"joint_positions": joints, "tip_pose": tips, "contact_force": force, "contact_arc_length": s}
    every = estimated_corners(signals)
    found = estimated_contact(signals, every)
    assert found is not None
    X_WB = random.normal(size=(7, 3, 4))
    for i in range(7):
        one = {name: value[i].ravel() for name, value in signals.items()}
        alone = estimated_corners(one)
        np.testing.assert_array_equal(every[i], alone)
        contact = estimated_contact(one, alone)
        assert contact is not None
        np.testing.assert_allclose([*found.force[i], found.side[i]], [*contact.force, contact.side], atol=1e-12)
        np.testing.assert_allclose(points_on_links(every, s)[0][i], points_on_links(alone, s[i])[0], atol=1e-12)
        np.testing.assert_allclose(to_world(X_WB, every)[i], alone @ X_WB[i, :, :3].T + X_WB[i, :, 3], atol=1e-12)


def drawn(finger: Finger, force: np.ndarray, sideways: float = 0.3) -> Drawing:
    drawing = Drawing()
    shown = DrawnFinger("finger", finger, 12, BodyIndex(0), (), dict.fromkeys(SHAPES[0], 0))
    place_arrow(drawing, shown)  # type: ignore[arg-type]
    place_ribbon(drawing, shown)  # type: ignore[arg-type]
    corners = corners_of(finger, sideways)
    draw_arrow(drawing, shown, corners, Contact(force, np.array(0.07), np.array(np.pi / 2)), 0.1)  # type: ignore[arg-type]
    draw_links(drawing, f"{BAND}/finger", corners, 0.1)  # type: ignore[arg-type]
    widen_ribbon(drawing, shown, np.full(13, 1e-3), 0.1)  # type: ignore[arg-type]
    return drawing


def test_the_arrow_is_the_force_where_the_surface_is_pressed(shipped_finger: Finger) -> None:
    force = np.array([0.2, -0.9, 0.3])
    seen = drawn(shipped_finger, force)
    begin = seen.in_world(f"{ARROW}/shaft/middle", [0, 0, -0.5])
    end = seen.in_world(f"{ARROW}/head/middle", [0, 0, 0])
    expected = pressed_point(shipped_finger, corners_of(shipped_finger, 0.3), 0.07, np.pi / 2)
    np.testing.assert_allclose(begin, expected, atol=3e-6)
    np.testing.assert_allclose(end - begin, LENGTH * force, atol=3e-6)


def test_the_ribbon_lies_along_the_links(shipped_finger: Finger) -> None:
    """Two standard deviations to either side, across the leaning finger."""
    seen, corners = drawn(shipped_finger, np.zeros(3)), corners_of(shipped_finger, 0.3)
    for i in (0, 6, 12):
        middle = (corners[i] + corners[i + 1]) / 2
        np.testing.assert_allclose(seen.in_world(f"{BAND}/finger/{i}", [0, 0, 0]), middle, atol=3e-6)
        left, right = (seen.in_world(f"{BAND}/finger/{i}/left", [x, 0, 0]) for x in (-0.5, 0.5))
        wide = np.linalg.norm(right - left)
        assert wide == pytest.approx(2e-3 if i == 0 else 4e-3, abs=3e-6)


LIMIT = 0.2


def test_blue_holds_open_and_red_closes() -> None:
    red, _, blue = color(np.array([-0.1, 0.1]), LIMIT).T
    assert blue[0] - red[0] > 0.3
    assert red[1] - blue[1] > 0.3


@pytest.mark.parametrize("torque", [1.0, 0.19, 0.2, 0.2000001, 0.31, 3e-4, 0.05, 7.0, 12.0])
def test_round_limit_is_the_least_round_number_that_holds_the_torque(torque: float) -> None:
    round_numbers = [float(f"{digit}e{power}") for power in range(-5, 3) for digit in (1, 2, 3, 5)]
    assert round_limit(torque) == pytest.approx(min(n for n in round_numbers if n >= torque))
