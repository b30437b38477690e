"""The pages of the API: one for each public name."""

import inspect

import pytest
from api_pages import api_pages, groups
from links import ROOT

import soft_gripper as sg


@pytest.fixture(scope="module")
def pages():
    return dict(api_pages())


@pytest.mark.parametrize("name", sg.__all__)
def test_every_public_name_has_a_page(pages, name):
    page = pages[f"api/{name}.md"]
    path = page.partition("From [")[2].partition("]")[0]
    assert (ROOT / path).is_file()
    value = getattr(sg, name)
    if inspect.isclass(value) or inspect.isfunction(value):
        assert f":: {name}\n" in page
        assert inspect.getdoc(value), "nothing is said of it"
    else:
        assert f"{name}" in page.partition("```python\n")[2].partition("```")[0]


def test_the_index_has_every_name_once(pages):
    names = [name for of_group in groups().values() for name in of_group]
    assert sorted(names) == sg.__all__
    assert all(f"[`{name}`]({name}.md)" in pages["api/index.md"] for name in names)


def test_pages_have_fields_and_ports(pages):
    assert (
        "| `sensor_spacing` | `float` |  | m, between inner and outer sensor path (Delta_R) |" in pages["api/Finger.md"]
    )
    assert "| `strain` | out |" in pages["api/StrainSensor.md"]
    assert "## Ports" not in pages["api/Finger.md"]
