"""The page of the schema: every field of every class that a scenario is made of."""

import re

import pytest
from schema_page import field_names, scenario_classes, schema_page

SECTIONS = {part.partition("\n")[0]: part for part in schema_page().split("\n## ")[1:]}


@pytest.mark.parametrize("cls", scenario_classes(), ids=lambda cls: cls.__name__)
def test_every_field_is_listed(cls):
    listed = re.findall(r"^\| `(\w+)` \|", SECTIONS[cls.__name__], re.MULTILINE)
    assert listed == field_names(cls)


def test_the_classes_are_those_of_a_scenario():
    found = {cls.__name__ for cls in scenario_classes()}
    assert {"Scenario", "PhaseConfig", "TrialsConfig", "PidGains", "UncertaintyConfig", "MultibodyPlantConfig"} <= found
    assert set(SECTIONS) == found | {"Changes of fingers"}


def test_a_row_has_type_default_values_and_meaning():
    row = "| `period` | `float` | `0.01` | s, above 0 | between samples, of the sensors and of every log |"
    assert row in SECTIONS["SensorConfig"]
    assert "| `command` | `str` | `'tension'` | tension or pull |" in SECTIONS["TendonConfig"]
    assert "[`list[PhaseConfig]`](#phaseconfig)" in SECTIONS["TaskConfig"]
    assert "Changes of its &lt;finger>s, by name" in SECTIONS["ModelConfig"]
    assert "| `time_step` | `0.01` | s, at least 0 |" in SECTIONS["MultibodyPlantConfig"]
    assert "| `contact.hydroelastic_modulus` | Pa, above 0 |" in SECTIONS["Changes of fingers"]
