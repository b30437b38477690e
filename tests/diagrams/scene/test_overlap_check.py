"""Nothing may begin inside something else."""

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

ANOTHER_BOX = "{name: other, file: package://soft_gripper/objects/box.sdf, free: true}"


def at(model, x, y, z):
    return f"models.{model}.X_PC.translation=[{x}, {y}, {z}]"


# Scenario, what is moved (m), and the models that are then in each other. Half the box is 22 x 20 x 30 mm. The fingers
# of its scenario reach from x = 35 mm outward and from z = 147 mm down, the palm from there up, the table from 0 down.
# The peg has a radius of 10 mm, and stands beside a finger that reaches from x = -35 mm outward.
INSIDE = {
    "object in a finger": ("box_grasp", [at(2, -0.03, 0, 0.09)], {"gripper::left_finger", "box::box"}),
    "object in the palm": ("box_grasp", [at(2, 0, 0, 0.13)], {"gripper::palm", "box::box"}),
    "mesh in a finger": ("irregular_grasp", [at(2, 0.03, 0, 0.09)], {"gripper::right_finger", "irregular::irregular"}),
    "finger in a finger": ("free_bending", [at(1, -0.13, 0, 0.2)], {"left_finger::", "right_finger::"}),
    "object in an object": ("box_grasp", [f"models.1={ANOTHER_BOX}", at(1, 0, 0, 0.05)], {"other::box", "box::box"}),
}


@pytest.mark.parametrize(("name", "overrides", "models"), INSIDE.values(), ids=INSIDE)
def test_a_start_inside_is_refused(name, overrides, models):
    with refused("X_PC") as caught:
        make_station(load_scenario(name, overrides))
    assert all(model in str(caught.value) for model in models)
