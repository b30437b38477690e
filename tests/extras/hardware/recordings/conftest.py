"""Descriptions of made-up recordings."""

from collections.abc import Callable
from pathlib import Path

import pytest
from hardware_files import DESCRIPTION

from soft_gripper.extras.hardware.recording_schema import RecordingConfig, load_description

Describe = Callable[..., RecordingConfig]


@pytest.fixture
def describe(tmp_path: Path) -> Describe:
    """Reads a description, of markers at a finger 0.1 m long, with more or other lines of YAML."""

    def read(more: str = "", text: str = DESCRIPTION) -> RecordingConfig:
        path = tmp_path / "described.yaml"
        path.write_text(text + more, encoding="utf-8")
        return load_description(path)

    return read
