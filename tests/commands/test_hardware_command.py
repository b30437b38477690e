"""soft-gripper hardware as a user calls it."""

from command_line import soft_gripper


def test_a_missing_folder_is_one_line(tmp_path):
    outcome = soft_gripper("hardware", "--data", tmp_path / "nowhere", "--out", tmp_path / "out")
    assert outcome.code == 2
    assert "there is no such folder" in outcome.err
    assert outcome.err.count("\n") == 1
    assert not (tmp_path / "out").exists()
