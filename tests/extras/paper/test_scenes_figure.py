"""Fig. 8: pairs of pictures as large as one another, in rows, none over another."""

from itertools import pairwise

import pytest

from soft_gripper.extras.paper.scenes_figure import (
    GAP,
    HEIGHT,
    MAX_ROW_WIDTH,
    largest_pressure,
    pair_places,
)
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
