"""What commands print of steady states, and of objects that slip."""

import math
from dataclasses import replace

import pytest

from soft_gripper.commands.printing import print_grasps, print_poses, print_slips
from soft_gripper.runs.scores.grasp import UNKNOWN
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.recorded_grasps import ObjectGrasp, ObjectGrip
from soft_gripper.runs.scores.recorded_slips import ObjectSlip
from soft_gripper.runs.scores.slipping import WILL_SLIP


def printed_poses(capsys: pytest.CaptureFixture[str], *turns: float) -> list[str]:
    print_poses([PoseRow("s", "finger", "arcs", "as simulated", 4, 60.0, 12.0, 0.1, 0.2, *turns)])
    return capsys.readouterr().out.splitlines()[1:]


def test_a_finger_in_space_turns_sideways_and_twists(capsys: pytest.CaptureFixture[str]) -> None:
    heading, units, row = printed_poses(capsys, -3.0, -1e-9)
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


SLIPS = {"slips_s": 3.2, "slips_in": "lift", "slips_on": "left", "used_share": 0.8}
FRICTION = {"present_friction": 0.21, "least_friction": 0.25, "least_object_friction": 0.15}
FORCE = {"present_force_n": 1.18, "needed_force_n": 1.39}


def printed(capsys, **slip) -> str:
    print_slips([ObjectSlip("cup", **slip)])
    return capsys.readouterr().out


def test_a_slip_says_when_where_and_what_would_have_held(capsys):
    lines = printed(capsys, predicted=WILL_SLIP, weight_share=1.18, lost_s=4.85, **SLIPS, **FRICTION, **FORCE)
    text = " ".join(lines.split())
    assert "takes 118% of the friction available: it will slip" in text
    assert "cup slips from 3.20 s in 'lift' on left, and is lost at 4.85 s" in text
    assert "80% of the friction available was used" in text
    assert "1.39 N a finger (1.18 N then)" in text
    assert "0.25 (0.21 here): models.cup.friction of 0.15" in text
    assert max(map(len, lines.splitlines())) <= 76  # of code blocks of the pages


def test_a_grasp_is_printed_without_nan(capsys):
    known = {"slip_ratio": 7.0, "normal_force_n": 0.06, "least_force_n": 0.41, "pump_energy_mj": 180.0}
    grasp = ObjectGrasp("cup", **vars(replace(UNKNOWN, grasp="dropped", **known)))
    print_grasps([grasp], [ObjectGrip("cup", "left", 0.058, 0.075, 1.1, math.nan, 1.6, 78.5)])
    out = capsys.readouterr().out
    assert "It slips below 0.41 N of 0.06 N (700%)\n" in out
    assert "nan" not in out


def test_a_friction_that_no_object_has_is_not_proposed(capsys):
    text = printed(capsys, **SLIPS, **FORCE, **FRICTION | {"least_object_friction": math.inf})
    assert "is lost" not in text
    assert "models.cup.friction" not in text
