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


@pytest.mark.slow
def test_the_font_has_what_browsers_need_for_equations(tmp_path):
    save_font(tmp_path / "math.woff")
    font = TTFont(tmp_path / "math.woff")
    assert "MATH" in font
    assert "Open Font License" in font["name"].getDebugName(13)
    used = "".join(to_mathml(equation.strip()) for page in THEORY for equation in equations(page))
    letters = {character for text in ET.fromstring(f"<page>{used}</page>").itertext() for character in text.strip()}
    assert {ord(letter) for letter in letters} - {0x2061} <= font.getBestCmap().keys()
