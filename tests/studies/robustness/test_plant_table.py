"""Other plants in a table: a finger that is known reads as itself, one of rubber as its nominal model."""

import numpy as np
import pytest

from soft_gripper.fingers.statics import softened
from studies.robustness import rows as module
from studies.robustness.plants import FINE, RUBBER
from studies.robustness.rows import Errors, plant_table, shipped_finger


def test_believed_fingers_are_the_shipped_ones() -> None:
    assert shipped_finger("free_bending", "right_finger").segments == 12
    assert shipped_finger("box_grasp", "left_finger").name == "left_finger"
    with pytest.raises(KeyError):
        shipped_finger("box_grasp", "thumb")


def test_a_finger_that_is_known_errs_by_no_more_than_its_chain(held) -> None:
    rows = plant_table(FINE, "free_bending", [held], 20, ["gaussian"])
    assert [row.sections for row in rows] == [1, 2, 3, 4]
    assert all(row.mean_mm < 0.2 for row in rows)
    assert {(row.plant, row.scenario, row.estimator) for row in rows} == {("24 segments", "free_bending", "gaussian")}


def test_rubber_is_read_by_sensors_with_errors(held) -> None:
    known, rubber = (plant_table(plant, "free_bending", [held], 3, ["gaussian"])[3] for plant in (FINE, RUBBER))
    assert rubber.mean_mm > 2 * known.mean_mm
    assert rubber.tip_mm > 2 * known.tip_mm
    assert 0 < rubber.coverage <= 1


def test_numbers_of_a_row_are_those_of_all_fingers_together(held, monkeypatch) -> None:
    """Of two fingers alike: mean, 95th percentile and worst of the pose, and the mean of the tip, in mm."""
    errors = Errors(1e-3 * np.array([0, 0, 0, 0, 10.0]), 1e-3 * np.array([2, 2, 2, 2, 12.0]), np.array([True, False]))
    monkeypatch.setattr(module, "estimated", lambda *_: errors)
    row = plant_table(FINE, "free_bending", [held, held], 1, ["gaussian"])[0]
    found = row.mean_mm, row.p95_mm, row.worst_mm, row.tip_mm, row.coverage
    assert found == pytest.approx((2.0, 10.0, 10.0, 4.0, 0.5))


def test_of_rubber_the_modulus_is_known_to_a_tenth(held, monkeypatch) -> None:
    given = []
    monkeypatch.setattr(module, "estimated", lambda *args: given.append(args[2]) or Errors(*np.zeros((3, 1))))
    plant_table(RUBBER, "free_bending", [held], 2, ["gaussian"])
    np.testing.assert_allclose([uncertainty.bend_per_pressure for uncertainty in given], np.hypot(0.1, 0.005))


def test_of_rubber_the_shipped_finger_is_believed_and_else_the_one_that_is_simulated(held, monkeypatch) -> None:
    nominal = []
    monkeypatch.setattr(module, "estimated", lambda *args: nominal.append(args[1].finger) or Errors(*np.zeros((3, 1))))
    shipped = softened(held.simulated, 2.0)
    monkeypatch.setattr(module, "shipped_finger", lambda *_: shipped)
    for plant, finger in ((RUBBER, shipped), (FINE, held.simulated)):
        nominal.clear()
        plant_table(plant, "free_bending", [held], 1, ["gaussian"])
        assert set(nominal) == {finger}
