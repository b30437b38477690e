"""XML text from users: the only place where it is parsed."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.text import read_text

_DEEPEST = 100  # elements inside each other
_MOST = 50_000  # elements: many times as many as any model has, and fewer than take minutes


def read_xml(path: Path) -> ET.Element:
    """The root element of a file; raises as `parse_xml` and `read_text`."""
    return parse_xml(path, read_text(path))


def parse_xml(where: Path | str, text: str) -> ET.Element:
    """The root element of XML text, with its comments.

    A DOCTYPE is refused: no model file needs one, and its entities can grow without bound or name other files.

    Raises:
        InputError: if the text is not well-formed, has a DOCTYPE, is nested too deeply, or is too large.
    """
    try:
        return ET.fromstring(text, ET.XMLParser(target=_Builder(where)))
    except ET.ParseError as error:
        raise InputError(where, "file", Path(where).name, f"is not well-formed XML: {error}") from None
    except UnicodeEncodeError:
        raise InputError(where, "file", Path(where).name, "is not well-formed XML: it holds half characters") from None


class _Builder(ET.TreeBuilder):
    def __init__(self, where: Path | str):
        super().__init__(insert_comments=True)
        self._where, self._depth, self._count = where, 0, 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise InputError(self._where, "DOCTYPE", name, "leave it out; a model needs none, nor entities")

    def start(self, tag: str, attrs: dict[str, str]) -> ET.Element:
        self._depth += 1
        self._count += 1
        if self._count > _MOST:
            raise InputError(self._where, "element", tag, f"is one of more than {_MOST}: no model needs as many")
        if self._depth > _DEEPEST:
            raise InputError(self._where, "element", tag, f"lies in more than {_DEEPEST} others")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ET.Element:
        self._depth -= 1
        return super().end(tag)


LEAST, MOST = 1e-30, 1e15  # of the size of a number that is not 0: enough for all that models contain, in SI units
_NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?inf(inity)?", re.ASCII | re.IGNORECASE)
_WORDS = {1: "a number", 2: "two numbers", 3: "three numbers", 4: "four numbers"}


def read_numbers(where: object, field: str, text: str, *counts: int) -> tuple[float, ...]:
    """The numbers of a text, which may be infinite.

    Args:
        where, field: for the message.
        text: numbers with white space between them.
        counts: how many are allowed; none: any number.

    Raises:
        InputError: if it contains anything else, or another number of them.
    """
    words = text.split()
    if any(_NUMBER.fullmatch(word) is None for word in words) or (counts and len(words) not in counts):
        expected = " or ".join(_WORDS.get(count, f"{count} numbers") for count in counts if count) or "numbers"
        raise InputError(where, field, text, f"give {expected}")
    return tuple(map(float, words))


def finite_numbers(where: object, field: str, text: str, *counts: int, least: float = LEAST) -> tuple[float, ...]:
    """The numbers of a text, as `read_numbers`, but finite and of a plausible size.

    `least` is 0 where rounding leaves tiny numbers in the place of 0, as in positions, angles and products of
    inertia.

    Raises:
        InputError: if it contains anything else.
    """
    numbers = read_numbers(where, field, text, *counts)
    for number in numbers:
        if not (number == 0 or least <= abs(number) <= MOST):
            sizes = f"0, or {least:g} to {MOST:g}" if least else f"up to {MOST:g}"
            raise InputError(where, field, text, f"give finite numbers: {sizes} in size")
    return numbers


def number(where: object, element: ET.Element | None, attribute: str) -> float:
    """The value of an attribute; 0, as in URDF, if the attribute or the element is missing.

    Raises:
        InputError: if it is not a number.
    """
    text = "0" if element is None else element.get(attribute, "0")
    tag = "" if element is None else element.tag
    (value,) = read_numbers(where, f"{tag}.{attribute}", text, 1)
    return value
