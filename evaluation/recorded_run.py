"""A recording in a file, with the scenario and the fingers that it is of."""

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.scene.plant import add_plant
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import parse_scenario
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger


class RecordedRun(NamedTuple):
    """What was recorded, and of what."""

    recording: Recording
    scenario: Scenario
    fingers: Sequence[PlantFinger]


def load_run(file: Path) -> RecordedRun:
    """Reads a recording that `soft-gripper run` wrote.

    Raises:
        InputError: if the file is none, or there is no finger in it.
    """
    try:
        recording = Recording.load(file)
        scenario = parse_scenario(file, recording.data.attrs["scenario"])
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise InputError(file, "file", file.name, f"is no recording of a scenario: {error}") from None
    scene = add_plant(DiagramBuilder(), scenario.plant_config, scenario.models, scenario.gravity, scenario.arm)
    if not scene.fingers:
        raise InputError(file, "fingers", [], "there is no finger in the recording")
    return RecordedRun(recording, scenario, scene.fingers)


def read_signal(file: object, recording: Recording, name: str) -> Array:
    """A signal of the recording in `file`, (T, ...).

    Raises:
        InputError: if it was not recorded.
    """
    if name not in recording.data:
        raise InputError(file, "signal", name, "is not in the recording")
    values: Array = recording[name].values
    return values
