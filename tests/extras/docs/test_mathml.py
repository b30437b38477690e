"""The equations of the pages: docutils can read all of them."""

import re
import xml.etree.ElementTree as ET

import pytest
from links import ROOT

pytest.importorskip("ziamath")
from fontTools.ttLib import TTFont
from mathml import save_font, to_mathml

THEORY = sorted((ROOT / "docs" / "theory").glob("*.md"))


def equations(page):
    blocks = re.split(r"\$\$", page.read_text(encoding="utf-8"))
    assert len(blocks) % 2 == 1
    return [*blocks[1::2], *(equation for text in blocks[::2] for equation in re.split(r"\$", text)[1::2])]


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_bars_that_stretch_are_pairs(page):
    """Of \\left and \\right, at both ends of a row: \\lvert and \\rvert are made of two unequal lengths."""
    for equation in equations(page):
        for row in ET.fromstring(to_mathml(equation.strip())).iter():
            found = [i for i, part in enumerate(row) if part.text == "|" and part.get("stretchy") != "false"]
            assert found in ([], [0, len(row) - 1]), equation


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_fractions_have_braces(page):
    """Docutils reads \\tfrac12 X as 12 over X."""
    assert [equation for equation in equations(page) if re.search(r"frac\s*\d", equation)] == []


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


def test_bars_open_and_close():
    found = ET.fromstring(to_mathml("|a| < |b|^2")).iter("{http://www.w3.org/1998/Math/MathML}mo")
    assert [bar.get("form") for bar in found if bar.text == "|"] == ["prefix", "postfix"] * 2


def test_limits_of_a_sum_stay_below_and_above_it():
    assert skeleton(r"\displaystyle \sum_i^n x_i").count("munderover(mo, mi, mi)") == 1
    assert skeleton("x_i^2") == "msubsup(mi, mi, mn)"


@pytest.mark.slow
def test_the_font_has_what_browsers_need_for_equations(tmp_path):
    save_font(tmp_path / "math.woff")
    font = TTFont(tmp_path / "math.woff")
    assert "MATH" in font
    assert "Open Font License" in font["name"].getDebugName(13)
    used = "".join(to_mathml(equation.strip()) for page in THEORY for equation in equations(page))
    letters = {character for text in ET.fromstring(f"<page>{used}</page>").itertext() for character in text.strip()}
    assert {ord(letter) for letter in letters} - {0x2061} <= font.getBestCmap().keys()
