"""Equations as MathML, by docutils, with a font: they need no script and no network in the reader's browser.

The font is STIX Two Math, cut to what equations use. Its metadata, which is kept, names its licence (SIL OFL 1.1).
"""

import xml.etree.ElementTree as ET
from logging import WARNING, getLogger
from pathlib import Path
from typing import Any

import ziamath
from docutils import nodes
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from fontTools.subset import Options, Subsetter
from fontTools.ttLib import TTFont
from sphinx.application import Sphinx
from sphinx.util import logging

_LOGGER = logging.getLogger(__name__)
_MATHML = "http://www.w3.org/1998/Math/MathML"
_FONT = Path(ziamath.__file__).parent / "fonts" / "STIXTwoMath-Regular.ttf"
_BLOCKS = (  # of Unicode
    range(0x20, 0x400),  # Latin, accents, Greek
    range(0x2000, 0x2400),  # punctuation, arrows, operators, brackets
    range(0x27C0, 0x2800),  # more brackets
    range(0x1D400, 0x1D4D0),  # bold, italic and script letters
    range(0x1D6A4, 0x1D800),  # Greek ones and digits
)


def setup(app: Sphinx) -> dict[str, Any]:
    """Makes "mathml" a value of `html_math_renderer`, whose font is _static/math.woff."""
    app.connect("build-finished", _add_font)
    app.add_html_math_renderer("mathml", (_visit_inline, None), (_visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def to_mathml(tex: str, as_block: bool = False) -> str:
    """An equation as MathML.

    Raises:
        MathError: docutils cannot read it.
    """
    tree = ET.fromstring(tex2mathml(tex, as_block=as_block).replace("&ApplyFunction;", "\u2061"))
    for element in tree.iter(f"{{{_MATHML}}}munderover"):
        if _is_accent(element[2]):
            _put_subscript_beside(element)
    bars = [element for element in tree.iter(f"{{{_MATHML}}}mo") if element.text == "|"]
    for opening, closing in zip(bars[::2], bars[1::2], strict=False):  # else spaced as relations are
        opening.set("form", "prefix")
        closing.set("form", "postfix")
    for element in tree.iter():
        element.tag = element.tag.removeprefix(f"{{{_MATHML}}}")  # the empty prefix is one for all writers of XML
    tree.set("xmlns", _MATHML)
    return ET.tostring(tree, encoding="unicode")


def save_font(path: Path) -> None:
    """Writes the font of the equations, WOFF."""
    getLogger("fontTools").setLevel(WARNING)  # it logs every table
    font = TTFont(_FONT)
    options = Options(name_IDs=["*"])
    options.layout_features += ["ssty"]  # the forms of subscripts
    subset = Subsetter(options)
    subset.populate(unicodes=[character for block in _BLOCKS for character in block])
    subset.subset(font)
    font.flavor = "woff"
    font.save(path)


def _add_font(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.format == "html":
        save_font(Path(app.outdir) / "_static" / "math.woff")


def _is_accent(over: ET.Element) -> bool:
    """Whether docutils made it of an accent (a dot, a hat, a line), rather than of the limit of a sum."""
    return over.get("stretchy") == "false" or over.get("accent") == "true"


def _put_subscript_beside(element: ET.Element) -> None:
    """Docutils puts the subscript of a dotted symbol below it: underset and accent become accent, then subscript."""
    base, below, accent = element
    accented = ET.Element(f"{{{_MATHML}}}mover", accent="true")
    accented.extend([base, accent])
    element.tag = f"{{{_MATHML}}}msub"
    element[:] = [accented, below]


def _visit_inline(translator: Any, node: nodes.math) -> None:
    translator.body.append(_checked(node))
    raise nodes.SkipNode


def _visit_block(translator: Any, node: nodes.math_block) -> None:
    translator.body.append(f'<div class="math">{_checked(node, as_block=True)}</div>')
    raise nodes.SkipNode


def _checked(node: nodes.math | nodes.math_block, as_block: bool = False) -> str:
    try:
        return to_mathml(node.astext(), as_block)
    except MathError as error:
        _LOGGER.warning("%s", error, location=node)
        return ""
