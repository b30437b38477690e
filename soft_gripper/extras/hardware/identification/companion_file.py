"""Writes and reads the YAML files that a fit leaves beside the file of an identified finger, such as its confidence."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

import yaml

from soft_gripper.files.document import load_config
from soft_gripper.files.output import atomic_file
from soft_gripper.files.yaml_text import read_yaml


class _Dataclass(Protocol):
    __dataclass_fields__: ClassVar[dict[str, Any]]


Content = TypeVar("Content", bound=_Dataclass)


@dataclass(frozen=True)
class CompanionFile(Generic[Content]):
    """Form of a file, with the dataclass of its fields. Another form is an instance of this class."""

    suffix: str  # instead of that of the finger's file
    head: str  # first line
    schema: type[Content]

    def file(self, finger: Path) -> Path:
        """Path of the file for a finger."""
        return finger.with_suffix(self.suffix)

    def write(self, finger: Path, content: Content, remarks: Sequence[str] = ()) -> None:
        """Writes the file with remarks in its head, whole or not at all."""
        fields = asdict(content)
        is_flat = not any(isinstance(value, list) for value in fields.values())
        text = yaml.safe_dump(fields, sort_keys=False, default_flow_style=False if is_flat else None, width=120)
        with atomic_file(self.file(finger)) as partial:
            partial.write_text("".join(f"# {line}\n" for line in (self.head, *remarks)) + text, encoding="utf-8")

    def read(self, finger: Path) -> Content | None:
        """Reads the fields of the file; None without a file."""
        file = self.file(finger)
        return load_config(file, read_yaml(file), self.schema) if file.exists() else None
