"""XML text of the user's: the one place where it is parsed."""

import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.reading import read_text

_DEEPEST = 100  # elements inside each other


def read_xml(path: Path) -> ET.Element:
    """The root element of a file; raises as `parse_xml` and `read_text`."""
    return parse_xml(path, read_text(path))


def parse_xml(where: Path | str, text: str) -> ET.Element:
    """The root element of XML text, with its comments.

    A DOCTYPE is refused: no model file needs one, and its entities can grow without bound or name other files.

    Raises:
        InputError: if the text is not well-formed, has a DOCTYPE, or is nested without end.
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
        self._where, self._depth = where, 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise InputError(self._where, "DOCTYPE", name, "leave it out; a model needs none, nor entities")

    def start(self, tag: str, attrs: dict[str, str]) -> ET.Element:
        self._depth += 1
        if self._depth > _DEEPEST:
            raise InputError(self._where, "element", tag, f"lies in more than {_DEEPEST} others")
        return super().start(tag, attrs)

    def end(self, tag: str) -> ET.Element:
        self._depth -= 1
        return super().end(tag)
