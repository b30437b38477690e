import numpy as np
from pydrake.systems.primitives import PassThrough

from soft_gripper.extras.bench.live_tables import finger_table, needed_signals, readings_table
from soft_gripper.extras.bench.watch import Counts
from soft_gripper.signals import describe


def port(size=1, meanings=()):
    return describe(PassThrough(size).get_output_port(), "1", meanings, **({"entry": range(size)} if size > 1 else {}))


KNOWN = {
    "left.tip_pose": port(3),
    "left.position_std": port(2),
    "left.contact_force": port(),
    "left.contact_force_std": port(),
    "left.contact_answer": port(meanings=("nothing touches", "touched here")),
    "right.tip_pose": port(3),
    "right.fault": port(meanings=("healthy", "dead")),
}
VALUES = {
    "left.tip_pose": np.array([0.0123, 0.11, 0.2]),
    "left.position_std": np.array([0.0, 0.00042]),
    "left.contact_force": np.array([0.5]),
    "left.contact_force_std": np.array([0.04]),
    "left.contact_answer": np.array([1.0]),
    "right.fault": np.array([1.0]),
}


def rows(values):
    _, head, *found = finger_table(["left", "right"], KNOWN, values)
    assert head == ["", "left", "right"]
    return {title: cells for title, *cells in found}


def test_what_is_estimated_has_a_row_and_what_is_not_has_none():
    assert set(needed_signals(["left", "right"], KNOWN)) == set(KNOWN)
    found = rows(VALUES)
    assert found["tip x, z [mm]"] == ["12.3, 110.0", "-"]
    assert found["tip ± [mm]"] == ["0.42", "-"]
    assert found["force [N]"] == ["0.50 ± 0.04", "-"]
    assert found["contact"] == ["touched here", "-"]
    assert "at most [N]" not in found


def test_a_bound_that_is_not_known_is_no_number():
    ports = {"left.contact_probability": port(), "left.contact_force_bounds": port(3)}
    bounds = {"left.contact_probability": np.array([0.1])}
    for bound, text in ((0.42, "0.42"), (np.nan, "not known")):
        given = bounds | {"left.contact_force_bounds": np.array([1.0, 2.0, bound])}
        assert finger_table(["left"], ports, given)[-1] == ["at most [N]", text]


def test_a_fault_is_marked():
    assert rows(VALUES)["health"] == ["-", ("dead", "bad")]
    assert rows({"right.fault": np.array([0.0])})["health"] == ["-", "healthy"]


def test_a_finger_far_from_its_calibration_is_marked():
    ports = {"left.is_far": port(meanings=("no", "far")), "left.state_distance": port(3)}
    for far, cell in ((0.0, "within, 2.3 spreads away"), (1.0, ("far, 2.3 spreads away", "bad"))):
        given = {"left.is_far": np.array([far]), "left.state_distance": np.array([0.1, 2.3, 0.0])}
        assert finger_table(["left"], ports, given)[-1] == ["calibration", cell]
    assert finger_table(["left", "right"], ports, given, ["right"])[-1][1:] == ["agree", ("disagree", "bad")]


def test_an_unknown_band_is_left_out():
    assert rows(VALUES | {"left.contact_force_std": np.array([np.nan])})["force [N]"] == ["0.50", "-"]


def test_before_the_first_reading_nothing_is_known():
    assert {cell for cells in rows({}).values() for cell in cells} == {"-"}


def test_counters_of_what_went_wrong_are_marked():
    _, head, *found = readings_table(Counts(used=7, lost=2))
    cells = [cell for row in found for cell in row]
    assert head == []
    assert cells[:6] == [("used", "name"), "7", ("lost", "name"), ("2", "bad"), ("late", "name"), "0"]
