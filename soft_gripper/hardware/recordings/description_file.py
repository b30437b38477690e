"""Descriptions of hardware recordings: finding, reading and checking them."""

import os
from pathlib import Path

from soft_gripper.files.document import load_config, require
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.hardware.recordings.schema import RecordingConfig
from soft_gripper.models import DIRECTORY

SHIPPED = DIRECTORY / "recordings"


def description_names() -> list[str]:
    """Names of the shipped descriptions."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_description(name_or_path: str | Path) -> RecordingConfig:
    """Reads a shipped description by its name, such as "clamped_beam", or any by its path.

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml"):
        path = SHIPPED / f"{name_or_path}.yaml"
        known = ", ".join(description_names())
        shipped = str(name_or_path) in description_names()
        require(shipped, "recording", "--as", str(name_or_path), f"not shipped; known: {known}; or give a path")
    config = load_config(path, read_yaml(path), RecordingConfig)
    if config.finger is not None and not config.finger.startswith("package://"):
        config.finger = os.path.realpath(path.parent / config.finger)
    return config
