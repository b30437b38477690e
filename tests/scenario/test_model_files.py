"""Files of models are found by path or package, or refused in one line."""

from refusals import refused

from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.model_files import model_path

BOX = "package://soft_gripper/objects/box.sdf"


def test_a_package_of_ours_is_where_its_files_are():
    assert model_path(BOX) == DIRECTORY / "objects" / "box.sdf"
    assert model_path(BOX).is_file()


def test_an_unknown_package_names_the_known_ones():
    with refused("file", "package://nosuch/thing.sdf"):
        model_path("package://nosuch/thing.sdf")
