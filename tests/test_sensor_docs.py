"""docs/sensors.md: its code runs as it stands, and it leaves out no field and no preset."""

import re
from dataclasses import fields
from pathlib import Path

import matplotlib as mpl
import pytest

from soft_gripper.scenario.schema import StrainErrorsConfig, presets
from soft_gripper.sensors.pressure_errors import PressureErrors

TEXT = (Path(__file__).parents[1] / "docs/sensors.md").read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_figure_is_drawn_as_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    (code,) = (block for block in re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL) if "savefig" in block)
    exec(compile(code, "docs/sensors.md", "exec"), {})
    assert (tmp_path / "sensor_errors.png").stat().st_size > 10_000


@pytest.mark.parametrize(
    "name",
    [*presets(), *(field.name for config in (StrainErrorsConfig, PressureErrors) for field in fields(config))],
)
def test_everything_is_explained(name):
    assert f"`{name}`" in TEXT or f"{name}:" in TEXT
