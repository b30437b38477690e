"""The ribbon of an estimated curve's uncertainty: its width, where it lies, and what is not known."""

import numpy as np
from drawing import Drawing
from pydrake.multibody.tree import BodyIndex

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.estimate_visualizer import BAND, DrawnFinger, draw_ribbon, place_ribbon
from soft_gripper.estimators.arcs import join_arcs
from soft_gripper.fingers.finger import Finger

STD = np.linspace(0.1e-3, 2e-3, 13)  # m


def drawn(finger: Finger, std: Array = STD, bend: float = 0.0) -> Drawing:
    drawing, lengths = Drawing(), np.full(12, 0.01)
    shown = DrawnFinger("finger", finger, np.arange(13), BodyIndex(0), (), has_band=True)
    place_ribbon(drawing, shown)  # type: ignore[arg-type]
    draw_ribbon(drawing, shown, join_arcs(np.full(12, bend), lengths), std, 0.1)  # type: ignore[arg-type]
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
    bend, kappa = 0.1, 10.0
    seen, s = drawn(shipped_finger, bend=bend), shipped_finger.link_ends
    middles = np.array([seen.in_world(f"{BAND}/finger/{i}", [0, 0, 0]) for i in range(13)])
    heading = kappa * (s[:-1] + s[1:]) / 2
    np.testing.assert_allclose(
        middles[:, [0, 2]].T, [(1 - np.cos(heading)) / kappa, np.sin(heading) / kappa], atol=3e-6
    )
    lengths = [seen.objects[f"{BAND}/finger/{i}/left"].height() for i in range(13)]
    assert np.all(lengths > np.diff(s))


def test_what_is_not_known_is_hidden(shipped_finger: Finger) -> None:
    seen = drawn(shipped_finger, np.where(np.arange(13) < 6, STD, np.nan))
    assert [seen.properties[f"{BAND}/finger/{i}", "visible"] for i in range(13)] == [True] * 6 + [False] * 7


def test_no_uncertainty_leaves_something_that_can_be_drawn(shipped_finger: Finger) -> None:
    seen = drawn(shipped_finger, np.zeros(13))
    assert all(seen.properties[f"{BAND}/finger/{i}", "scale"][0] > 0 for i in range(13))
