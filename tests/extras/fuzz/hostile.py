"""What strangers write: values, and changes of texts, from which the fuzz test composes its input."""

import xml.etree.ElementTree as ET
from typing import Any

from hypothesis import strategies as st

NUMBERS = (
    *("0", "-1", "1", "2.5", "1e308", "-1e308", "5e-324", "1e-12", "1e12", "nan", ".nan", "inf", "-.inf", "9" * 5000),
    *("0x10", "1_0", "٣", "²", "", " ", "1,2", "1e999", "4294967296", "-0.0", "1e-7", "100000"),
)
WORDS = (
    *("", " ", "x", "world", "plant", "all", "logs", "a.b", "a b", "δ", "<b>&amp;", "$x$"),
    *("..", "../..", ".", "/", "~", "none.urdf", "file:///nowhere", "a\u0301\u202e"),
    *("x" * 300, "y" * 50_000, "package://", "package://../..", "package://soft_gripper/../x", "os:system", ":", "%s"),
    *("null", "true", "yes", "no", "2001-01-01", "!!binary aGk=", "${x}"),
)
YAML_VALUES: tuple[Any, ...] = (
    *(None, True, 0, -1, 2, 1.5, 1e308, 5e-324, 1e-12, float("nan"), float("inf"), 10**400, 2**63, 1e5, -1e-3),
    *([], {}, [[]], [0], [1, 2, 3], [1, 2, 3, 4], [None], ["x"], {"a": 1}, {1: 2}, {None: 1}, {"_tag": "!Uniform"}),
    *WORDS,
)
FACTORS = st.sampled_from((-1.0, 0.1, 10.0, 1e-3, 1e3, 1e-6, 1e6, 1e-9, 1e9))  # mistaken units, and worse
_WAYS = ("attribute", "attribute", "attribute", "text", "tag", "remove", "double", "move")  # to change an element
SNIPPETS = (
    *("<", ">", "&", "]]>", "<!--", "<!DOCTYPE x [<!ENTITY a 'b'>]>", "&a;", '"', "'", "\t", "\r", "\n\n", "\\"),
    *("{", "}", "[", ":", "- ", "? ", "*a", "&a ", "!foo ", "%TAG ! x:\n---\n", "---\n", "<<: "),
    *("\x01", "\ufeff", "\x85", "\udcff"),
)


@st.composite
def texts(draw: st.DrawFn, base: str) -> str:
    """A text in which one to three spots are cut, doubled, or hold a snippet, a number or a word."""
    text = base
    for _ in range(draw(st.integers(1, 3))):
        begin = draw(st.integers(0, len(text)))
        end = min(len(text), begin + draw(st.sampled_from((0, 0, 1, 3, 10, 100))))
        kind = draw(st.sampled_from(("cut", "double", "insert")))
        between = {"cut": "", "double": 2 * text[begin:end]}.get(kind) if kind != "insert" else draw(_PIECES)
        text = text[:begin] + str(between) + text[end:]
    return text


def _scaled(text: str, factor: float) -> str | None:
    """A number, or several, in another unit; None if it is none."""
    try:
        return " ".join(str(factor * float(word)) for word in text.split())
    except ValueError:
        return None


_PIECES = st.one_of(st.sampled_from(SNIPPETS), st.sampled_from(NUMBERS), st.sampled_from(WORDS))


@st.composite
def documents(draw: st.DrawFn, base: Any) -> Any:
    """Plain data in which one to three values are replaced, left out, or get another key."""
    document = base
    for _ in range(draw(st.integers(1, 3))):
        document = _changed(draw, document)
    return document


def _changed(draw: st.DrawFn, value: Any) -> Any:
    """The same data but for one place below."""
    inside = isinstance(value, dict | list) and len(value) and draw(st.integers(0, 5))
    if not inside:
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return draw(st.sampled_from(YAML_VALUES)) if not is_number or draw(st.booleans()) else value * draw(FACTORS)
    entries = dict(value.items() if isinstance(value, dict) else enumerate(value))
    place = draw(st.sampled_from(list(entries)))
    how = draw(st.sampled_from(("deeper", "deeper", "deeper", "leave out", "rename")))
    if how == "leave out":
        del entries[place]
    elif how == "rename" and isinstance(value, dict):
        entries[draw(st.sampled_from((*WORDS, 1, None, True, 2.5, "_tag", "<<")))] = entries.pop(place)
    else:
        entries[place] = _changed(draw, entries[place])
    return entries if isinstance(value, dict) else list(entries.values())


@st.composite
def elements(draw: st.DrawFn, base: str) -> str:
    """XML text in which one to three elements lose, double or move, or get another attribute or text."""
    root = ET.fromstring(base)
    for _ in range(draw(st.integers(1, 3))):
        all_elements = list(root.iter())
        parents = [element for element in all_elements if len(element)] or [root]
        element = draw(st.sampled_from(all_elements))
        how = draw(st.sampled_from(_WAYS))
        value = draw(st.sampled_from((*NUMBERS, *NUMBERS, *WORDS, "0 0 0", "nan 0 0", "1 1")))
        if how == "attribute" and element.attrib:
            name = draw(st.sampled_from(sorted(element.attrib)))
            if draw(st.booleans()) and (scaled := _scaled(element.attrib[name], draw(FACTORS))):
                element.set(name, scaled)
            elif draw(st.integers(0, 4)):
                element.set(name, value)
            else:
                del element.attrib[name]
        elif how == "text":
            element.text = value
        elif how == "tag":
            element.tag = draw(st.sampled_from(("link", "joint", "finger", "x", "frame", "mesh", "gazebo", "inertial")))
        elif how in ("double", "move"):
            draw(st.sampled_from(parents)).append(ET.fromstring(ET.tostring(element)))
        elif how == "remove":
            parent = draw(st.sampled_from(parents))
            if len(parent):
                parent.remove(draw(st.sampled_from(list(parent))))
    return ET.tostring(root, encoding="unicode")
