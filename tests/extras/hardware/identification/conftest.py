"""What the tests of identification share: fingers, and one process that simulates."""

import pytest
from identified import BEAM, HOLLOW, finger_of

from soft_gripper.runs.executor import open_executor


@pytest.fixture(scope="session")
def beam(tmp_path_factory):
    """A solid finger that creeps."""
    return finger_of(BEAM, tmp_path_factory.mktemp("beam"))


@pytest.fixture(scope="session")
def hollow(tmp_path_factory):
    """The same with a chamber."""
    return finger_of(HOLLOW, tmp_path_factory.mktemp("hollow"))


@pytest.fixture(scope="session")
def pool():
    with open_executor(1) as executor:
        yield executor
