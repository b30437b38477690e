"""Files of models are found by path or package, or refused in one line."""

from refusals import refused

from soft_gripper.scenario.model_files import model_path


def test_an_unknown_package_names_the_known_ones():
    with refused("file", "package://nosuch/thing.sdf"):
        model_path("package://nosuch/thing.sdf")
