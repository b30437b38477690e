import numpy as np
from pydrake.systems.primitives import PassThrough

from soft_gripper.extras.bench.live_tables import finger_table, needed_signals
from soft_gripper.signals import describe

NAN = np.nan


def port(size=1, meanings=()):
    return describe(PassThrough(size).get_output_port(), "1", meanings, **({"entry": range(size)} if size > 1 else {}))


KNOWN = {
    "left.tip_pose": port(3),
    "left.position_std": port(2),
    "left.transverse_force": port(),
    "left.transverse_force_std": port(),
    "left.contact_answer": port(meanings=("nothing touches", "touched here")),
    "left.contact_probability": port(),
    "left.contact_force_bounds": port(3),
    "left.is_far": port(meanings=("no", "far")),
    "left.state_distance": port(3),
    "right.tip_pose": port(3),
    "right.fault": port(meanings=("healthy", "dead")),
}
VALUES = {
    "left.tip_pose": [0.0123, 0.11, 0.2],
    "left.position_std": [0.0, 0.00042],
    "left.transverse_force": [0.5],
    "left.transverse_force_std": [0.04],
    "left.contact_answer": [1.0],
    "left.contact_probability": [0.1],
    "left.contact_force_bounds": [1.0, 2.0, 0.42],
    "left.is_far": [0.0],
    "left.state_distance": [0.1, 2.3, 0.0],
    "right.fault": [0.0],
}
OTHERS = {"left.transverse_force_std": [NAN], "left.contact_force_bounds": [1.0, 2.0, NAN], "left.is_far": [1.0]}


def cells(values, disagreeing=()):
    """Left and right of each row."""
    given = {name: np.array(value) for name, value in values.items()}
    _, head, *found = finger_table(["left", "right"], KNOWN, given, disagreeing)
    assert head == ["", "left", "right"]
    return {title: tuple(row) for title, *row in found}


def test_what_is_estimated_of_any_finger_has_a_row():
    """Without a band or bound that is not known; what is at fault or far from its calibration is marked."""
    assert set(needed_signals(["left", "right"], KNOWN)) == set(KNOWN)
    found = cells(VALUES)
    assert found == {
        "tip x, z [mm]": ("12.3, 110.0", "-"),
        "tip ± [mm]": ("0.42", "-"),
        "contact": ("touched here", "-"),
        "transverse force [N]": ("0.50 ± 0.04", "-"),
        "at most [N]": ("0.42", "-"),
        "health": ("-", "healthy"),
        "calibration": ("within, 2.3 spreads away", "-"),
    }
    others = cells(VALUES | OTHERS | {"right.fault": [1.0]}, ["right"])
    assert others == found | {
        "transverse force [N]": ("0.50", "-"),
        "at most [N]": ("not known", "-"),
        "health": ("-", ("dead", "bad")),
        "calibration": (("far, 2.3 spreads away", "bad"), "-"),
        "readings and drive": ("agree", ("disagree", "bad")),
    }
    assert {cell for row in cells({}).values() for cell in row} == {"-"}
