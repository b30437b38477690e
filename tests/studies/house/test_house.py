"""What grew: files are counted in the room that they are in."""

import pytest

from studies.house.house import room


@pytest.mark.parametrize(
    ("path", "name"),
    [
        ("soft_gripper/errors.py", "soft_gripper, lines"),
        ("soft_gripper/model_import/forms/urdf.py", "soft_gripper/model_import, lines"),
        ("soft_gripper/extras/mine/commands/weigh.py", "soft_gripper/extras/mine, lines"),
        ("diagrams/wiring/drive.py", "diagrams, lines"),
        ("docs/howto/own_arm.md", "docs, words"),
        ("README.md", "top level, words"),
    ],
)
def test_a_file_is_counted_in_its_room(path, name):
    assert room(path) == name
