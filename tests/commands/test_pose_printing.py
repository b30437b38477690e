"""The table of steady states: fingers in space turn in more ways than one."""

import pytest

from soft_gripper.commands.printing import print_poses
from soft_gripper.runs.scores.poses import PoseRow


def printed(capsys: pytest.CaptureFixture[str], *turns: float) -> list[str]:
    print_poses([PoseRow("s", "finger", "arcs", "as simulated", 4, 60.0, 12.0, 0.1, 0.2, *turns)])
    return capsys.readouterr().out.splitlines()[1:]


def test_a_finger_in_space_turns_sideways_and_twists(capsys: pytest.CaptureFixture[str]) -> None:
    heading, units, row = printed(capsys, -3.0, -1e-9)
    assert heading.split("  ")[1:] == [
        "pressure",
        "bend angle",
        "sideways angle",
        "twist angle",
        "pose error",
        "tip error",
    ]
    assert units.split() == ["[kPa]", "[degrees]", "[degrees]", "[degrees]", "[mm]", "[mm]"]
    assert row.split() == ["finger", "60.0", "12.00", "-3.00", "0.00", "0.100", "0.200"]
