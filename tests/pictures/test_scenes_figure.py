"""Fig. 8: pairs of pictures as large as one another, in rows, none over another."""

from itertools import pairwise, product

import numpy as np
import pytest
from scenes import Scene

from soft_gripper.pictures.scenes_figure import GAP, HEIGHT, ROW, pair_places


def test_pairs_fill_rows_and_stand_in_their_middle() -> None:
    places = pair_places([9.0, 4.0, 5.0, 4.0])
    assert [width for *_, width in places] == [9.0, 4.0, 5.0, 4.0]
    tops = [top for _, top, _ in places]
    assert tops[0] == 0 < tops[1] == tops[2] < tops[3]
    across = 4.0 + GAP + 5.0
    assert [left for left, *_ in places] == pytest.approx([(across - 9) / 2, 0, 4 + GAP, (across - 4) / 2])


def test_a_pair_that_is_wider_than_a_row_has_one_alone() -> None:
    places = pair_places([2.0, ROW + 1, 2.0])
    assert all(below[1] - above[1] > HEIGHT for above, below in pairwise(places))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "body", "size", "inside"),
    [
        ("obstructed_inside", "peg", (0.02, 0.06, 0.02), True),
        ("obstructed_outside", "peg", (0.02, 0.06, 0.02), True),
        ("box_grasp", "top", (0.5, 0.36, 0.04), False),
    ],
)
def test_a_peg_in_the_way_is_inside_the_picture_and_a_table_may_reach_out_of_it(
    name: str, body: str, size: tuple[float, ...], inside: bool
) -> None:
    """`size` in metres, as the model files of what is fixed say."""
    scene = Scene(name)
    renderer = scene.renderer(scene.state())
    corners = [scene.point(body, np.array(signs) * size / 2) for signs in product((-1, 1), repeat=3)]
    seen = renderer.camera.project(np.array(corners))
    assert ((seen > 0) & (seen < (renderer.camera.width, renderer.camera.height))).all() == inside
