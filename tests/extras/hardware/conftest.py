"""What the tests of hardware share: fingers, one process that simulates, and descriptions of recordings."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hardware_files import DESCRIPTION
from identified import BEAM, HOLLOW, finger_of

from soft_gripper.extras.hardware.recording_schema import RecordingConfig, load_description
from soft_gripper.extras.sweeps.executor import open_executor

Describe = Callable[..., RecordingConfig]


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


@pytest.fixture
def describe(tmp_path: Path) -> Describe:
    """Reads a description, of markers at a finger 0.1 m long, with more or other lines of YAML."""

    def read(more: str = "", text: str = DESCRIPTION) -> RecordingConfig:
        path = tmp_path / "described.yaml"
        path.write_text(text + more, encoding="utf-8")
        return load_description(path)

    return read
