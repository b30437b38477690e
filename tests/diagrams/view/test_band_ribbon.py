"""The ribbon of an estimated curve's uncertainty: its width, where it lies, and what is not known."""

import numpy as np
from drawing import Drawing
from pydrake.multibody.tree import BodyIndex

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.estimate_visualizer import BAND, DrawnFinger, draw_links, place_ribbon, widen_ribbon
from soft_gripper.diagrams.view.finger_drawing import estimated_corners
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, forward_kinematics

STD = np.linspace(0.1e-3, 2e-3, 13)  # m


def drawn(finger: Finger, std: Array = STD, bend: float = 0.0) -> Drawing:
    drawing, shown = Drawing(), DrawnFinger("finger", finger, 12, BodyIndex(0), ())
    chain = forward_kinematics(np.full(12, bend), finger.segment_length)
    tip = np.array([*as_points(chain.tip), 12 * bend])
    corners = estimated_corners({"joint_positions": as_points(chain.joints).ravel(), "tip_pose": tip})
    place_ribbon(drawing, shown)  # type: ignore[arg-type]
    draw_links(drawing, f"{BAND}/finger", corners, 0.1)  # type: ignore[arg-type]
    widen_ribbon(drawing, shown, std, 0.1)  # type: ignore[arg-type]
    return drawing


def test_is_two_standard_deviations_wide_on_either_side(shipped_finger: Finger) -> None:
    """Of a straight finger, in the mean over the ends of each link; at the base there is none."""
    seen, ends = drawn(shipped_finger), np.concatenate([[0], STD])
    for i in range(13):
        for side in ("left", "right"):
            path = f"{BAND}/finger/{i}/{side}"
            edges = [seen.in_world(path, [x, 0, 0])[0] for x in (-0.5, 0.5)]
            np.testing.assert_allclose(edges, np.array([-1, 1]) * (ends[i] + ends[i + 1]), atol=3e-6)


def test_follows_the_curve_without_gaps(shipped_finger: Finger) -> None:
    seen, lengths = drawn(shipped_finger, bend=0.1), np.diff(shipped_finger.link_ends)
    end = np.zeros(3)
    for i, length in enumerate(lengths):
        begin, next_end = (seen.in_world(f"{BAND}/finger/{i}", [0, 0, half]) for half in (-length / 2, length / 2))
        np.testing.assert_allclose(begin, end, atol=3e-6)
        end = next_end
        assert seen.objects[f"{BAND}/finger/{i}/left"].height() > length
    assert end[0] > 0.03


def test_what_is_not_known_is_hidden(shipped_finger: Finger) -> None:
    seen = drawn(shipped_finger, np.where(np.arange(13) < 6, STD, np.nan))
    assert [seen.properties[f"{BAND}/finger/{i}/left", "visible"] for i in range(13)] == [True] * 6 + [False] * 7


def test_no_uncertainty_leaves_something_that_can_be_drawn(shipped_finger: Finger) -> None:
    seen = drawn(shipped_finger, np.zeros(13))
    assert all(seen.properties[f"{BAND}/finger/{i}/right", "scale"][0] > 0 for i in range(13))
