"""The pages of the API: one for each public name."""

import inspect

import pytest
from api_pages import api_pages
from links import ROOT
from public_names import public, public_names

pytestmark = pytest.mark.slow

NAMES = [name for names in public_names().values() for name in names]


@pytest.fixture(scope="module")
def pages():
    return dict(api_pages())


@pytest.mark.parametrize("name", NAMES)
def test_every_public_name_has_a_page(pages, name):
    page = pages[f"api/{name}.md"]
    path = page.partition("From [")[2].partition("]")[0]
    assert (ROOT / path).is_file()
    value = public(name)
    if inspect.isclass(value) or inspect.isfunction(value):
        assert f":: {name.rpartition('.')[2]}\n" in page
        assert inspect.getdoc(value), "nothing is said of it"
    else:
        assert name.rpartition(".")[2] in page.partition("```python\n")[2].partition("```")[0]
