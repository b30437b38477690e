"""Other plants in a table: a finger that is known reads as itself, one of rubber as what is believed of it."""

import pytest

from soft_gripper.estimators.shape_functions import SHAPE_FUNCTIONS
from soft_gripper.evaluation.robustness import plant_table as module
from soft_gripper.evaluation.robustness.plant_table import plant_table, shipped_finger
from soft_gripper.evaluation.robustness.plants import FINE, RUBBER


@pytest.fixture(autouse=True)
def one_estimator(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "SHAPE_FUNCTIONS", {"gaussian": SHAPE_FUNCTIONS["gaussian"]})


def test_believed_fingers_are_the_shipped_ones() -> None:
    assert shipped_finger("free_bending", "right_finger").segments == 12
    assert shipped_finger("box_grasp", "left_finger").name == "left_finger"
    with pytest.raises(KeyError):
        shipped_finger("box_grasp", "thumb")


def test_a_finger_that_is_known_errs_by_no_more_than_its_chain(held) -> None:
    rows = plant_table(FINE, "free_bending", [held], 20)
    assert [row.sections for row in rows] == [1, 2, 3, 4]
    assert all(row.mean_mm < 0.2 for row in rows)
    assert {(row.plant, row.scenario, row.estimator) for row in rows} == {("24 segments", "free_bending", "gaussian")}


def test_rubber_is_read_by_sensors_with_errors(held) -> None:
    known, rubber = (plant_table(plant, "free_bending", [held], 3)[3] for plant in (FINE, RUBBER))
    assert rubber.mean_mm > 2 * known.mean_mm
    assert rubber.tip_mm > 2 * known.tip_mm
    assert 0 < rubber.coverage <= 1
