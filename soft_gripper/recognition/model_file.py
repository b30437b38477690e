"""Shape models as JSON files."""

import json
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text
from soft_gripper.recognition.model import ShapeModel
from soft_gripper.scenario.model_files import model_path

_DIGITS = 9  # of a weight


def save_shape_model(model: ShapeModel, path: Path) -> None:
    """Writes a model, a line a field."""
    content = {
        name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in asdict(model).items()
    }
    lines = (f"  {json.dumps(name)}: {json.dumps(_rounded(value))}" for name, value in content.items())
    with atomic_file(path) as partial:
        partial.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def load_shape_model(file: Path | str) -> ShapeModel:
    """Reads what `save_shape_model` wrote.

    Args:
        file: a path or package://soft_gripper/... URI.

    Raises:
        InputError: if the file is missing, no shape model, or what is in it does not fit.
    """
    path = model_path(str(file))
    text = read_text(path)
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(path, "file", path.name, "is not JSON") from None
    names = [field.name for field in fields(ShapeModel)]
    if not isinstance(content, dict) or sorted(content) != sorted(names):
        found = list(content) if isinstance(content, dict) else type(content).__name__
        raise InputError(path, "fields", found, f"a shape model has: {', '.join(names)}")
    try:
        return ShapeModel(**{name: _value(name, content[name]) for name in names})
    except InputError as error:
        raise error.inside(path) from None


def _value(name: str, value: Any) -> Any:
    """A field from what JSON makes of it."""
    try:
        if name in ("fingers", "joints", "sections"):
            return int(value)
        return tuple(map(str, value)) if name == "shapes" else np.array(value, dtype=float)
    except (TypeError, ValueError):
        expected = "give whole numbers" if name in ("fingers", "joints", "sections") else "give a list, as it was saved"
        raise InputError("shape model", name, value, expected) from None


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(entry) for entry in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
