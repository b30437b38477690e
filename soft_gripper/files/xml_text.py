"""XML text from users: the only place where it is parsed."""

import re
import xml.etree.ElementTree as ET
from collections import Counter
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.number import DECIMAL
from soft_gripper.files.text import read_text

DRAKE = "{http://drake.mit.edu}"  # namespace of Drake's own elements, under whichever of its names a file has it
ET.register_namespace("drake", DRAKE.strip("{}"))
_DEEPEST_ELEMENT = 100  # elements inside each other
MAX_ELEMENTS = 50_000  # many times as many as any model has, and fewer than take minutes
MAX_CHARACTERS = 2**23  # many times as long as any model, but for one with all vertices of a large mesh
_MAX_WORD = 4096  # characters of names, as of a path; Drake's parsers recur for each character
_MAX_PREFIXES = 100  # without a declaration
_MAX_ATTRIBUTES = 200  # of an element
_TEXT_ATTRIBUTES = ("name", "model")  # may be numbers
_NUMBERS_PATTERN = re.compile(r"[-+.\deE\s]*")
_COMMENT_PATTERN = re.compile(r"<!--.*?(?:-->|\Z)", re.DOTALL)
_PREFIX_PATTERN = re.compile(r"(?<=[<\s/])([A-Za-z_][\w.-]*):[A-Za-z_][\w.-]*(?=[\s=/>])")
_ROOT_PATTERN = re.compile(r"<[A-Za-z_][\w:.-]*")
_DEFAULT_NAMESPACE_PATTERN = re.compile(r"""\sxmlns\s*=\s*("[^"]*"|'[^']*')""")
# What a model may have at most, which is more than others have: Drake takes time by the square of these.
_MAX_COUNTS = dict.fromkeys(("link", "body", "frame", "finger"), 500)
_MAX_COUNTS |= dict.fromkeys(("joint", "transmission", "default"), 1500)
_MAX_COUNTS |= dict.fromkeys(("visual", "collision", "geom"), 2500)
_MAX_SHAPES = 500  # in a link
LEAST, MOST = 1e-30, 1e15  # of the size of a number that is not 0: enough for all that models contain, in SI units
_NUMBER_PATTERN = re.compile(rf"{DECIMAL}|[-+]?inf(inity)?", re.IGNORECASE)
_COUNT_WORDS = {1: "a number", 2: "two numbers", 3: "three numbers", 4: "four numbers"}


def read_xml(path: Path) -> ET.Element:
    """The root element of a file; raises as `parse_xml` and `read_text`."""
    return parse_xml(path, read_text(path))


def parse_xml(where: Path | str, text: str) -> ET.Element:
    """The root element of XML text, with its comments.

    A DOCTYPE is refused: no model file needs one, and its entities can grow without bound or name other files. As
    the parsers of ROS and Drake do, this one accepts `--` inside comments, which are then lost, prefixes without a
    declaration, and white space before all else; a namespace of elements without a prefix means nothing.

    Raises:
        InputError: if the text is not well-formed, has a DOCTYPE, is nested too deeply, or it or a name is too long.
    """
    if len(text) > MAX_CHARACTERS:
        expected = f"has {len(text)} characters; give at most {MAX_CHARACTERS}, and meshes as files of their own"
        raise InputError(where, "file", Path(where).name, expected)
    text = _DEFAULT_NAMESPACE_PATTERN.sub("", text.lstrip())
    try:
        return _parse(where, text)
    except ET.ParseError as error:
        try:
            return _parse(where, _repair(where, text))
        except ET.ParseError:
            raise InputError(where, "file", Path(where).name, f"is not well-formed XML: {error}") from None
    except UnicodeEncodeError:
        raise InputError(where, "file", Path(where).name, "is not well-formed XML: it holds half characters") from None


def _parse(where: Path | str, text: str) -> ET.Element:
    return ET.fromstring(text, ET.XMLParser(target=_Builder(where)))


def _repair(where: Path | str, text: str) -> str:
    """XML text without comments, but with their lines, and with a declaration of each prefix that has none."""
    text = _COMMENT_PATTERN.sub(
        lambda comment: "\n" * comment[0].count("\n") if comment[0].endswith("-->") else "<", text
    )
    declared_prefixes = {"xml", "xmlns", *re.findall(r"\sxmlns:([\w.-]+)\s*=", text)}
    prefixes = sorted(set(_PREFIX_PATTERN.findall(text)) - declared_prefixes)
    if len(prefixes) > _MAX_PREFIXES:
        expected = f"is one of more than {_MAX_PREFIXES} prefixes without a declaration; declare them by xmlns"
        raise InputError(where, "prefix", prefixes[0], expected)
    uris = {"drake": DRAKE.strip("{}")}
    declarations = "".join(f' xmlns:{prefix}="{uris.get(prefix, prefix)}"' for prefix in prefixes)
    return _ROOT_PATTERN.sub(lambda root: root[0] + declarations, text, count=1)


class _Builder(ET.TreeBuilder):
    def __init__(self, where: Path | str):
        super().__init__(insert_comments=True)
        self._where, self._depth, self._count = where, 0, 0

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise InputError(self._where, "DOCTYPE", name, "leave it out; a model needs none, nor entities")

    def start(self, tag: str, attrs: dict[str, str]) -> ET.Element:
        self._depth += 1
        self._count += 1
        if self._count > MAX_ELEMENTS:
            raise InputError(self._where, "element", tag, f"is one of more than {MAX_ELEMENTS}: no model needs as many")
        if self._depth > _DEEPEST_ELEMENT:
            raise InputError(self._where, "element", tag, f"lies in more than {_DEEPEST_ELEMENT} others")
        if len(attrs) > _MAX_ATTRIBUTES:
            raise InputError(self._where, f"attributes of <{tag}>", len(attrs), f"give at most {_MAX_ATTRIBUTES}")
        self._check_length(tag, tag)
        for name, value in attrs.items():
            self._check_length(f"{tag}.{name}", name)
            if name in _TEXT_ATTRIBUTES or _NUMBERS_PATTERN.fullmatch(value) is None:
                self._check_length(f"{tag}.{name}", value)
        return super().start(_drake_tag(tag), attrs)

    def _check_length(self, field: str, word: str) -> None:
        if len(word) > _MAX_WORD:
            raise InputError(self._where, field, word, f"is longer than {_MAX_WORD} characters")

    def end(self, tag: str) -> ET.Element:
        self._depth -= 1
        return super().end(_drake_tag(tag))


def _drake_tag(tag: str) -> str:
    """A tag, in Drake's namespace if a file has that by another name, such as drake.mit.edu."""
    uri, _, name = tag.rpartition("}")
    return DRAKE + name if uri.endswith("drake.mit.edu") else tag


def check_counts(where: object, model: ET.Element) -> None:
    """Raises an InputError if a model has so many links, joints or shapes that Drake takes minutes for it."""
    counts = Counter(element.tag for element in model.iter() if isinstance(element.tag, str))
    for tag, max_count in _MAX_COUNTS.items():
        if counts[tag] > max_count:
            raise InputError(where, f"<{tag}>", counts[tag], f"give at most {max_count} of them")
    for link in [element for element in model.iter() if element.tag in ("link", "body")]:
        if (count := sum(shape.tag in ("collision", "geom") for shape in link)) > _MAX_SHAPES:
            place = f"{where}: {link.tag} '{link.get('name')}'"
            raise InputError(place, "shapes", count, f"give at most {_MAX_SHAPES}")


def read_numbers(where: object, field: str, text: str, *counts: int) -> tuple[float, ...]:
    """The numbers of a text, which may be infinite; raises an InputError if it contains anything else.

    `counts` are the allowed numbers of them; none: any.
    """
    words = text.split()
    if any(_NUMBER_PATTERN.fullmatch(word) is None for word in words) or (counts and len(words) not in counts):
        expected = " or ".join(_COUNT_WORDS.get(count, f"{count} numbers") for count in counts if count) or "numbers"
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


def number(where: object, element: ET.Element | None, name: str, default: str = "0") -> float:
    """A number of an element: its attribute or, as in SDFormat, its child of that name, or the `value` of that child.

    Raises:
        InputError: if it is not a number.
    """
    tag, text = ("", default) if element is None else (element.tag, element.get(name))
    if text is None and element is not None:
        child = element.find(name)
        text = default if child is None else child.get("value", child.text or "")
    (value,) = read_numbers(where, f"{tag}.{name}", text or "", 1)
    return value


def take(parent: ET.Element, *tags: str) -> list[ET.Element]:
    """Removes the children of an element with these tags, and returns them."""
    children = [child for tag in tags for child in parent.findall(tag)]
    for child in children:
        parent.remove(child)
    return children


def joint_end(joint: ET.Element, end: str) -> str:
    """The link at the `parent` or `child` of a joint: an attribute in URDF, a text in SDFormat, else empty."""
    element = joint.find(end)
    return "" if element is None else (element.get("link") or element.text or "").strip()
