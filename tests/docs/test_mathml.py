"""The equations of the pages: docutils can read all of them."""

import re
import xml.etree.ElementTree as ET

import pytest
from links import ROOT

pytest.importorskip("sphinx")
from mathml import to_mathml  # noqa: E402

THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_equations_can_be_read(page):
    blocks = re.split(r"\$\$", page.read_text(encoding="utf-8"))
    inline = [equation for text in blocks[::2] for equation in re.split(r"\$", text)[1::2]]
    assert len(blocks) % 2 == 1
    for equation in [*blocks[1::2], *inline]:
        assert "<math" in to_mathml(equation.strip())


def skeleton(tex):
    """An equation as nested names, such as msub(mi, mi)."""

    def names(element):
        inner = f"({', '.join(map(names, element))})" if len(element) else ""
        return element.tag.rpartition("}")[2] + inner

    return ", ".join(map(names, ET.fromstring(to_mathml(tex))))


@pytest.mark.parametrize(
    "accented", [r"\dot q", r"\dot{q}", r"\ddot q", r"\hat q", r"\bar q", r"\vec q", r"\overline{q}"]
)
def test_the_subscript_of_an_accented_symbol_is_beside_it(accented):
    assert skeleton(accented + "_i") == "msub(mover(mi, mo), mi)"


def test_limits_of_a_sum_stay_below_and_above_it():
    assert skeleton(r"\displaystyle \sum_i^n x_i").count("munderover(mo, mi, mi)") == 1
    assert skeleton("x_i^2") == "msubsup(mi, mi, mn)"
