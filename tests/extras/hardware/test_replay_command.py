"""soft-gripper replay as a user calls it."""

import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from hardware_files import DESCRIPTION, published, swinging, write_csv
from refusals import refusal


@pytest.mark.slow
def test_files_and_table(tmp_path):
    data = published("two_segment_arm").parent
    files = ["--as", "two_segment_arm", "--data", data, "--estimator", "arcs", "--out", tmp_path]
    outcome = soft_gripper("replay", "trial_5.txt", "--fit", "trial_1.txt", "trial_3.txt", *files)
    assert outcome.code == 0, outcome.err
    assert "trial_5      fitted to trial_1, trial_3" in outcome.out
    assert {row["recording"] for row in csv_rows(tmp_path / "replay.csv")} == {"trial_5", "all"}
    assert {path.name for path in tmp_path.iterdir()} == {"replay.csv", "replay.png", "replay.svg", "trial_5.nc"}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere.txt", "--as", "two_segment_arm"], "there is no such file here"),
        (["run.csv", "--as", "three_segment_arm"], "known: clamped_beam"),
        (["run.csv", "--as", "described.yaml"], "give the direction of gravity"),
    ],
)
def test_mistakes_are_named(tmp_path, monkeypatch, arguments, said):
    monkeypatch.chdir(tmp_path)
    write_csv(tmp_path / "run.csv", swinging())
    (tmp_path / "finger.urdf").write_text(FINGER)
    (tmp_path / "described.yaml").write_text(DESCRIPTION + "finger: finger.urdf\n")
    assert said in refusal("replay", *arguments)


FINGER = """<robot name="r"><link name="m"/>
<frame name="fingers: load with soft_gripper.add_fingers, or soft-gripper expand"/>
<finger name="f"><parent link="m"/><body length="0.1"/>
<base width="0.03" thickness="0.03" youngs_modulus="2.6e5" density="1070"/>
<tip width="0.03" thickness="0.03" youngs_modulus="2.6e5" density="1070"/><sensors spacing="0.02"/></finger></robot>
"""
