"""What was learned, as a file: parameters, and how the search went."""

from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from pydrake.common.yaml import yaml_dump

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.learning.gentle_grasp.learn import Generation
from soft_gripper.learning.gentle_grasp.policies import GentleParameters

SHIPPED = Path(__file__).with_name("learned.yaml")


def save_learned(path: Path, parameters: GentleParameters, curve: list[Generation]) -> None:
    """Writes a file."""
    document: dict[str, Any] = {"parameters": asdict(parameters), "curve": [each._asdict() for each in curve]}
    with atomic_file(path) as partial:
        partial.write_text(yaml_dump(document), encoding="utf-8")


def load_learned(path: Path = SHIPPED) -> tuple[GentleParameters, list[Generation]]:
    """Reads a file, that which is shipped unless it is said otherwise.

    Raises:
        InputError: if it is none that `save_learned` wrote.
    """
    document = read_yaml(path)
    try:
        numbers = document["parameters"]
        parameters = GentleParameters(**{field.name: float(numbers[field.name]) for field in fields(GentleParameters)})
        return parameters, [Generation(**generation) for generation in document["curve"]]
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(path, "file", path.name, f"is none of what was learned: {error}") from None
