"""What the options of `place-sensors` take, and what is refused at once."""

import pytest
from refusals import refused

from soft_gripper.commands.parser import parsed


def test_scenarios_are_a_list():
    line = ["place-sensors", "--count", "2", "--scenarios", "box_grasp,free_bending"]
    assert parsed(line).scenarios == ["box_grasp", "free_bending"]


@pytest.mark.parametrize(
    ("line", "field"),
    [
        ("--count 2 --nominal-error 100", "--nominal-error"),
        ("--count 2 --scenarios box_grasp --recordings a.nc", "--scenarios"),
    ],
)
def test_mistakes_name_the_option(line, field):
    with refused(field):
        parsed(["place-sensors", *line.split()])
