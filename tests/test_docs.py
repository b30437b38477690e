"""docs/finger.md and docs/sensors.md: their tables and figures are those of the code."""

import re
from dataclasses import fields
from pathlib import Path
from runpy import run_path

import matplotlib as mpl
import pytest

from soft_gripper.fingers.finger_element import SILICONES
from soft_gripper.scenario.schema import StrainErrorsConfig, presets
from soft_gripper.sensors.pressure_errors import PressureErrors

FINGER_TEXT = (Path(__file__).parents[1] / "docs/finger.md").read_text(encoding="utf-8")


def test_materials_are_those_of_the_code():
    rows = re.findall(r"^\| `(\w+)` \| (\d+) \| (\d+) \|", FINGER_TEXT, re.MULTILINE)
    written = {name: (int(modulus), int(density)) for name, modulus, density in rows}
    assert written == {name: (round(s.youngs_modulus / 1e3), s.density) for name, s in SILICONES.items()}


ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "sensors.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_figure_is_drawn(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    run_path(str(ROOT / "examples" / "pictures" / "sensor_errors.py"))
    assert (tmp_path / "results" / "sensor_errors.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "name",
    [*presets(), *(field.name for config in (StrainErrorsConfig, PressureErrors) for field in fields(config))],
)
def test_everything_is_explained(name):
    assert f"`{name}`" in TEXT or f"{name}:" in TEXT
