"""Stations that agents act on, built once for all tests."""

import pytest

from soft_gripper.extras.learning.config import load_environment
from soft_gripper.extras.learning.environment import SoftGripperEnv
from soft_gripper.extras.learning.station import make_learning_station


@pytest.fixture(scope="session")
def grasp_environment():
    """The file of SoftGrasp-v0, read."""
    return load_environment("soft_grasp")


@pytest.fixture(scope="session")
def grasp_station(grasp_environment):
    """A station of SoftGrasp-v0 as its scenario has it."""
    return make_learning_station(grasp_environment.config, grasp_environment.scenario)


@pytest.fixture(scope="session")
def one_gripper():
    """SoftGrasp-v0 with a single gripper and short episodes."""
    return SoftGripperEnv("soft_grasp", {"variation.grippers": 1, "duration": 0.5})
