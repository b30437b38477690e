"""Models read by Drake: what would end the process is checked before, and Drake's errors become one line."""

import os
import re
import xml.etree.ElementTree as ET
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from linecache import clearcache, getline, getlines
from pathlib import Path
from tempfile import TemporaryDirectory

from pydrake.multibody.parsing import Parser
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.cached import get_or_make
from soft_gripper.errors import InputError, first_line
from soft_gripper.files.document import require
from soft_gripper.files.notes import LEFT_OUT, READ
from soft_gripper.files.text import MAX_TEXT_BYTES, check_regular, read_text
from soft_gripper.files.xml_text import check_counts, joint_end, parse_xml
from soft_gripper.library_messages import MARK, PREFIX, drop_messages, original_message
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.model_numbers import check_numbers

_PACKAGE_SCHEMES = ("package://", "model://")


def check_inside(where: object, uri: str) -> None:
    """Checks the URI of a file in a package, package://NAME/PATH.

    Raises:
        InputError: if its path leads out of the package.
    """
    package, _, inside = uri.partition("://")[2].partition("/")
    stays = os.path.normpath(f"/{package}/{inside}").startswith(f"/{package}/")
    if package in ("", ".", "..") or not stays:
        raise InputError(where, "file", uri, "leads out of the package")


def check_uris(path: Path, uris: Iterable[str]) -> None:
    """Checks the meshes and models that a URDF or SDFormat file names, in any package or beside it.

    Raises:
        InputError: if one leads out of its package, or names something, such as a pipe, that is not a file or folder.
    """
    for uri in uris:
        if uri.startswith(_PACKAGE_SCHEMES):
            check_inside(path, uri)
        elif os.path.exists(file := path.parent / uri.removeprefix("file://")) and not os.path.isdir(file):
            require(os.path.isfile(file), path, "file", uri, "is not a regular file")
            check_regular(file)


def named_uris(root: ET.Element) -> Iterator[str]:
    """The meshes and models that a URDF or SDFormat file names."""
    for element in root.iter():
        for text in (element.get("filename", ""), element.text or "" if element.tag == "uri" else ""):
            if uri := text.strip():
                yield uri


_XML_SUFFIXES = (".urdf", ".sdf", ".world", ".xml", ".mjcf")


_HARMLESS_WARNING = "[drake:wall_boundary_condition]"  # which Drake 1.51 misses in soft objects, and does not need


_WARNING_PATTERN = re.compile(r"(?:\S+:\d+: )?(?:warning: )?(.*)", re.DOTALL)
_TAG_GAP = re.compile(r">\s*<")
_GEOM_PATTERN = re.compile(r"^geom \S+ specified")  # whose name would make each warning another one
_LINE_PATTERN = re.compile(r"\W*(/.*?):(\d+): ")


@contextmanager
def drake_reads(where: object, field: str, value: object, file: ModelFile | None = None) -> Iterator[None]:
    """Turns exceptions of Drake into an InputError; a failed condition of Drake arrives as SystemExit.

    While a `file` is read, warnings of Drake become notes on it.
    """

    def keep(message: str) -> bool:
        if file is not None and (match := _WARNING_PATTERN.fullmatch(original_message(message))):
            outcome = LEFT_OUT if "ignor" in match[1].lower() else READ
            file.note(outcome, _element(message), "", _GEOM_PATTERN.sub("it specifies", " ".join(match[1].split())))
        return file is None

    try:
        with drop_messages(lambda message: _HARMLESS_WARNING in message or not keep(message)):
            yield
    except InputError:
        raise
    except (RuntimeError, ValueError, IndexError, SystemExit) as error:
        if isinstance(error, SystemExit) and not isinstance(error.code, str):
            raise
        element = "" if (name := _element(str(error))) == "it" else f"{name}: "
        message = original_message(first_line(error))
        raise InputError(where, field, value, f"Drake cannot read it: {element}{message}") from None
    finally:
        clearcache()


_TAG_PATTERN = re.compile(r"<([\w:]+)")
_NAME_PATTERN = re.compile(r"""\sname=["']([^"']*)""")


def _element(message: str) -> str:
    """The element that a message is about, from the text that Drake reads, whose lines are not those of the file."""
    place = _LINE_PATTERN.match(message)
    tag = _TAG_PATTERN.search(line := getline(place[1], int(place[2]))) if place else None
    if tag is None:
        return "it"
    name = _NAME_PATTERN.search(line.partition(">")[0])
    return f"{tag[1]} '{name[1]}'" if name else f"<{tag[1]}>"


def add_file(parser: Parser, path: Path) -> list[ModelInstanceIndex]:
    """Reads the models of a file, unchanged; raises an InputError if it is XML that would end the process."""
    check_file(path)
    return list(parser.AddModels(str(path)))


def check_file(path: Path) -> ET.Element | None:
    """Checks a file that Drake is to read unchanged; returns its root element if it is XML.

    Raises:
        InputError: if it is XML that would end the process.
    """
    if path.suffix.lower() not in _XML_SUFFIXES:
        is_model = not path.name.endswith(".dmd.yaml")
        require(is_model, path, "file", path.name, "holds directives: add them by add_directives")
        check_regular(path, MAX_TEXT_BYTES)
        return None
    root = parse_xml(path, text := read_text(path))
    check_counts(path, root)
    _check(path, text, lambda: root)
    return root


def add_text(parser: Parser, text: str, path: Path, suffix: str) -> list[ModelInstanceIndex]:
    """Reads the text of a model derived from `path`, in a file with its name, so that Drake's messages give that name.

    Raises:
        InputError: if it would end the process.
    """
    _check(path, text, lambda: _refuse_includes(path, ET.fromstring(text)))
    with TemporaryDirectory(prefix=PREFIX) as folder:
        expanded = Path(folder) / f"{path.stem}{MARK}{suffix}"
        expanded.write_text(_TAG_GAP.sub(">\n<", text), encoding="utf-8")  # lines of messages tell elements apart
        getlines(str(expanded))  # kept while Drake's messages are read
        return list(parser.AddModels(str(expanded)))


def _refuse_includes(path: Path, root: ET.Element) -> ET.Element:
    """Returns the root of a model, and refuses includes: Drake follows files that include themselves without an end.

    Raises:
        InputError: for an <include> that is where no model can be.
    """
    for element in root.iter():
        if (include := element.find("include")) is not None:
            uri = include.findtext("uri") or include.get("file")
            raise InputError(
                path, f"{element.tag.rpartition('}')[2]}.include", uri, "include models in <sdf>, <world> or <model>"
            )
    return root


_MAX_CACHED_TEXTS = 16  # of about 0.1 MB: a sweep reads the same ones for every run
_named: OrderedDict[tuple[Path, str], tuple[str, ...]] = OrderedDict()


def _check(path: Path, text: str, root: Callable[[], ET.Element]) -> None:
    uris = get_or_make(_named, (path, text), lambda: _check_and_list_uris(path, root()), _MAX_CACHED_TEXTS)
    check_uris(path, uris)  # what they name may have changed, unlike the text


def _check_and_list_uris(path: Path, root: ET.Element) -> tuple[str, ...]:
    """Checks numbers and links of a model, and returns its URIs."""
    check_numbers(path, root)
    for model in root.iter("model") if root.tag == "sdf" else (root,):
        _check_tree(path, model)
    return tuple(dict.fromkeys(named_uris(root)))


def _check_tree(path: Path, model: ET.Element) -> None:
    """Refuses loops of links: Drake simulates trees, and fails only when the plant is finalized."""
    neighbors: dict[str, str] = {}  # a link, and another one that is connected to it

    def first(link: str) -> str:
        while link in neighbors:
            link = neighbors[link]
        return link

    for joint in model.findall("joint"):
        parent, child = (joint_end(joint, end) for end in ("parent", "child"))
        if not (parent and child):
            continue  # Drake reports what is missing
        if first(parent) == first(child):
            expected = "closes a loop of links; leave it out, since only trees of links are simulated"
            raise InputError(f"{path}: joint '{joint.get('name')}'", "parent, child", f"{parent}, {child}", expected)
        neighbors[first(child)] = first(parent)
