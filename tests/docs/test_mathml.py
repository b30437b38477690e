"""The equations of the pages: docutils can read all of them."""

import re

import pytest
from links import ROOT

latex2mathml = pytest.importorskip("docutils.utils.math.latex2mathml")
THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_equations_can_be_read(page):
    blocks = re.split(r"\$\$", page.read_text(encoding="utf-8"))
    inline = [equation for text in blocks[::2] for equation in re.split(r"\$", text)[1::2]]
    assert len(blocks) % 2 == 1
    for equation in [*blocks[1::2], *inline]:
        assert "<math" in latex2mathml.tex2mathml(equation.strip())
