"""Numbers of docs/extras/grasps/grasp_strength.md are those that a run gives, to the last digit."""

from pathlib import Path

import pytest
from printed_numbers import printed

from soft_gripper.extras.grasps.strength import LOADS, SettledGrasp, Shake
from soft_gripper.scenario.scenario_file import load_scenario

PAGE = (Path(__file__).parents[3] / "docs/extras/grasps/grasp_strength.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_row_of_each_kind_of_load():
    settled = SettledGrasp.from_scenario(load_scenario("bottle_grasp"), "bottle")
    (force,) = printed(PAGE, r"force along \+z, out of the grasp \| (.*) N \| slid")
    (torque,) = printed(PAGE, r"torque about x, both ways \| (.*) mN m \| turned")
    found = {(load.is_torque, load.name): load for load in LOADS}
    pull, turn = (settled.strength(found[key], Shake()) for key in ((False, "+z"), (True, "+x")))
    assert (f"{pull.strength:.2f}", pull.ended) == (force, "slid")
    assert (f"{turn.strength:.1f}", turn.ended) == (torque, "turned")
