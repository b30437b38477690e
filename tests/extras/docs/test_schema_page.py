"""The page of the schema: every field of every class that a scenario is made of."""

import re

import pytest
from schema_page import field_names, scenario_classes, schema_page

SECTIONS = {part.partition("\n")[0]: part for part in schema_page().split("\n## ")[1:]}


@pytest.mark.parametrize("cls", scenario_classes(), ids=lambda cls: cls.__name__)
def test_every_field_is_listed(cls):
    listed = re.findall(r"^\| `(\w+)` \|", SECTIONS[cls.__name__], re.MULTILINE)
    assert listed == field_names(cls)
