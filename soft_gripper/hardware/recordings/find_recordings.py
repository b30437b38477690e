"""Which files the user means, and how they are described."""

import os
from collections.abc import Sequence
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.document import given, require
from soft_gripper.hardware.recordings.hardware_recording import HardwareRecording
from soft_gripper.hardware.recordings.read_recording import read_recording
from soft_gripper.hardware.recordings.schema import RecordingConfig, load_description

DATA_FOLDER = "SOFT_GRIPPER_DATA"  # environment variable


def find_recordings(
    files: Sequence[str], described_as: str | None = None, data: Path | None = None
) -> list[HardwareRecording]:
    """Finds and reads recordings: the files of `recording_paths`, as they are described.

    Raises:
        InputError: if a file or description is not found, or wrong.
    """
    return [
        read_recording(path, _description(path, described_as)) for path in recording_paths(files, described_as, data)
    ]


def recording_paths(files: Sequence[str], described_as: str | None = None, data: Path | None = None) -> list[Path]:
    """Finds recordings.

    Args:
        files: each as given, or below `data`, or there in a folder named as the description.
        described_as: a shipped description's name, or a path; None: the YAML beside a file, with its name or
            recording.yaml.
        data: folder of recordings; None: the environment variable SOFT_GRIPPER_DATA.

    Raises:
        InputError: if a file is not found.
    """
    folder = data or (Path(os.environ[DATA_FOLDER]) if os.environ.get(DATA_FOLDER) else None)
    require(len(files) > 0, "recording", "FILE", [], "give at least one file")
    return [_find(file, described_as, folder) for file in files]


def _find(file: str, described_as: str | None, folder: Path | None) -> Path:
    places = [Path(file)]
    if folder is not None:
        places += [folder / file, *([folder / Path(described_as).stem / file] if described_as else [])]
    found = next((place for place in places if os.path.isfile(place)), None)
    below = f"nor below {folder}" if folder else f"and neither --data nor {DATA_FOLDER} names a folder"
    if found is None:
        raise InputError("recording", "FILE", file, f"there is no such file here, {below}")
    return found


def _description(path: Path, described_as: str | None) -> RecordingConfig:
    if described_as is not None:
        return load_description(described_as)
    places = path.with_suffix(".yaml"), path.with_name("recording.yaml")
    found = next((place for place in places if os.path.isfile(place)), None)
    expected = f"what does it hold? Give --as NAME, or put {places[0].name} or {places[1].name} beside it"
    return load_description(given(found, path, "description", expected))
