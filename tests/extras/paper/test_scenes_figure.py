"""Fig. 8: pairs of pictures as large as one another, in rows, none over another."""

from itertools import pairwise, product

import numpy as np
import pytest
from scenes import Scene

from soft_gripper.extras.paper.scenes_figure import (
    GAP,
    HEIGHT,
    MAX_ROW_WIDTH,
    largest_pressure,
    pair_places,
    scenes_figure,
)
from soft_gripper.pictures.rendering import SceneRenderer
from soft_gripper.scenario.scenario_file import load_scenario


def test_pairs_fill_rows_and_stand_in_their_middle() -> None:
    places = pair_places([9.0, 4.0, 5.0, 4.0])
    assert [width for *_, width in places] == [9.0, 4.0, 5.0, 4.0]
    tops = [top for _, top, _ in places]
    assert tops[0] == 0 < tops[1] == tops[2] < tops[3]
    across = 4.0 + GAP + 5.0
    assert [left for left, *_ in places] == pytest.approx([(across - 9) / 2, 0, 4 + GAP, (across - 4) / 2])


def test_a_pair_that_is_wider_than_a_row_has_one_alone() -> None:
    places = pair_places([2.0, MAX_ROW_WIDTH + 1, 2.0])
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


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ({"all": [0.0, 20e3, 50e3, 30e3]}, (6.0, 50e3)),
        ({"all": [10e3, -40e3]}, (4.0, -40e3)),
        ({"left_finger": [10e3, 20e3, 30e3], "right_finger": [0.0, 45e3]}, (4.0, 45e3)),
    ],
    ids=str,
)
def test_the_largest_pressure_is_found_at_the_end_of_its_step(
    steps: dict[str, list[float]], expected: tuple[float, float]
) -> None:
    scenario = load_scenario("free_bending", [f"pressure.steps={steps}"])
    assert largest_pressure(scenario) == pytest.approx(expected)


@pytest.mark.slow
def test_the_figure_of_scenes_shows_each_at_its_start_and_at_its_largest_pressure() -> None:
    runs = {}
    for name, steps in (("obstructed_inside", [0.0, 50e3, 20e3]), ("obstructed_outside", [0.0, -40e3, 0.0])):
        scene = Scene(name)
        scene.scenario.pressure.steps = {"all": steps}
        straight = scene.state()
        scene.bend("left_finger", 0.1)
        # The pressure is largest from 2 s to 4 s; only then the finger is bent.
        states = [scene.state() if time in (3, 4) else straight for time in range(7)]
        runs[name] = (scene.scenario, scene.recording(*states, torques=np.full(12, 0.03)))
    figure = scenes_figure(runs, height=60)
    starts, ends = np.array(figure.axes[:4]).reshape(2, 2).T
    for start, end, (name, run) in zip(starts, ends, runs.items(), strict=True):
        renderer = SceneRenderer(*run, 60, torque_limit=0.03)
        np.testing.assert_array_equal(start.images[0].get_array(), renderer.render(0.0))
        np.testing.assert_array_equal(end.images[0].get_array(), renderer.render(4.0))
        assert name.replace("_", " ") in start.get_title()
    assert [end.get_title() for end in ends] == ["50 kPa", "−40 kPa"]
    np.testing.assert_allclose(figure.axes[4].get_ylim(), [-30, 30])
