"""Models read by Drake: what would end the process is checked before, and Drake's errors become one line."""

import os
import re
import xml.etree.ElementTree as ET
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from linecache import clearcache, getline, getlines
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from pydrake.multibody.parsing import Parser
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.cached import get_or_make
from soft_gripper.errors import InputError, first_line
from soft_gripper.files.document import require
from soft_gripper.files.notes import LEFT_OUT, READ
from soft_gripper.files.text import MAX_TEXT_BYTES, check_regular, read_text
from soft_gripper.files.xml_text import DRAKE, LEAST, check_counts, finite_numbers, joint_end, parse_xml, read_numbers
from soft_gripper.library_messages import MARK, PREFIX, drop_messages, original_message
from soft_gripper.model_import.model_file import ModelFile

_PACKAGE_SCHEMES = ("package://", "model://")
_XML_SUFFIXES = (".urdf", ".sdf", ".world", ".xml", ".mjcf")
_HARMLESS_WARNING = "[drake:wall_boundary_condition]"  # which Drake 1.51 misses in soft objects, and does not need
_WARNING_PATTERN = re.compile(r"(?:\S+:\d+: )?(?:warning: )?(.*)", re.DOTALL)
_TAG_GAP = re.compile(r">\s*<")
_GEOM_PATTERN = re.compile(r"^geom \S+ specified")  # whose name would make each warning another one
_LINE_PATTERN = re.compile(r"\W*(/.*?):(\d+): ")
_TAG_PATTERN = re.compile(r"<([\w:]+)")
_NAME_PATTERN = re.compile(r"""\sname=["']([^"']*)""")
_MAX_CACHED_TEXTS = 16  # of about 0.1 MB: a sweep reads the same ones for every run
_named: OrderedDict[tuple[Path, str], tuple[str, ...]] = OrderedDict()
_MIN_SIZE, _MAX_SIZE = 1e-9, 1e6  # m, of a shape; some mark points by spheres of 0.1 um
_NAMED_TAGS = ("link", "joint", "model")
_LIMIT_FIELDS = ("lower", "upper", "velocity", "effort", "acceleration")  # infinite, or as good as, if there is none
_INERTIA_FIELDS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# How many numbers: of an attribute in URDF, by element and attribute, and of the text of an element in SDFormat.
_URDF_COUNTS: dict[str, dict[str, tuple[int, ...]]] = {
    "origin": {"xyz": (3,), "rpy": (3,)},
    "axis": {"xyz": (3,)},
    "box": {"size": (3,)},
    "sphere": {"radius": (1,)},
    "cylinder": {"radius": (1,), "length": (1,)},
    "capsule": {"radius": (1,), "length": (1,)},
    "ellipsoid": {"a": (1,), "b": (1,), "c": (1,)},
    "mesh": {"scale": (1, 3)},
    "mass": {"value": (1,)},
    "inertia": dict.fromkeys(_INERTIA_FIELDS, (1,)),
    "limit": dict.fromkeys(_LIMIT_FIELDS, (1,)),
    "dynamics": {"damping": (1,), "friction": (1,)},
    "mimic": {"multiplier": (1,), "offset": (1,)},
    "color": {"rgba": (4,)},
}
_SDF_COUNTS: dict[str, tuple[int, ...]] = {
    "pose": (0, 6, 7),
    "size": (2, 3),
    "scale": (1, 3),
    "radii": (3,),
    "xyz": (3,),
    "normal": (3,),
    **dict.fromkeys(("diffuse", "ambient", "specular", "emissive"), (3, 4)),
    **dict.fromkeys((*_INERTIA_FIELDS, "radius", "length", "mass", "lower", "upper", "velocity", "effort"), (1,)),
    **dict.fromkeys(("damping", "mu", "mu2", "spring_stiffness", "spring_reference"), (1,)),
}
_DRAKE_FIELDS = (
    *("mu_static", "mu_dynamic", "hydroelastic_modulus", "hunt_crossley_dissipation", "mesh_resolution_hint"),
    *("point_contact_stiffness", "relaxation_time", "rotor_inertia", "gear_ratio", "acceleration"),
)
_SOLIDS = ("box", "sphere", "cylinder", "capsule", "ellipsoid")
_SIZE_FIELDS = {f"{shape}.{name}" for shape in _SOLIDS for name in _URDF_COUNTS[shape]}
_SIZE_FIELDS |= {"size", "radius", "length", "radii"}
_ROUNDED_FIELDS = ("origin.xyz", "origin.rpy", "pose", "ixy", "ixz", "iyz", "inertia.ixy", "inertia.ixz", "inertia.iyz")
_NONZERO_FIELDS = ("axis.xyz", "xyz", "normal", "mesh.scale", "scale")
WITHOUT_AXIS = ("fixed", "floating", "ball")  # types of joints in URDF whose axis Drake does not read


def check_inside(where: object, uri: str) -> None:
    """Raises an InputError if the URI of a file in a package, package://NAME/PATH, leads out of it."""
    package, _, inside = uri.partition("://")[2].partition("/")
    stays = os.path.normpath(f"/{package}/{inside}").startswith(f"/{package}/")
    if package in ("", ".", "..") or not stays:
        raise InputError(where, "file", uri, "leads out of the package")


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


def _element(message: str) -> str:
    """The element that a message is about, from the text that Drake reads, whose lines are not those of the file."""
    place = _LINE_PATTERN.match(message)
    tag = _TAG_PATTERN.search(line := getline(place[1], int(place[2]))) if place else None
    if tag is None:
        return "it"
    name = _NAME_PATTERN.search(line.partition(">")[0])
    return f"{tag[1]} '{name[1]}'" if name else f"<{tag[1]}>"


def check_file(path: Path) -> ET.Element | None:
    """The root of a file for Drake, None without XML; raises an InputError if reading it would end the process."""
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
    """Returns the root of a model; refuses includes, as Drake follows files that include themselves without end."""
    for element in root.iter():
        if (include := element.find("include")) is not None:
            uri = include.findtext("uri") or include.get("file")
            field = f"{element.tag.rpartition('}')[2]}.include"
            raise InputError(path, field, uri, "include models in <sdf>, <world> or <model>")
    return root


def _check(path: Path, text: str, root: Callable[[], ET.Element]) -> None:
    """Checks a text, and that what it names is in its package, and is no pipe: that may have changed."""
    uris = get_or_make(_named, (path, text), lambda: _check_and_list_uris(path, root()), _MAX_CACHED_TEXTS)
    for uri in uris:
        if uri.startswith(_PACKAGE_SCHEMES):
            check_inside(path, uri)
        elif os.path.exists(file := path.parent / uri.removeprefix("file://")) and not os.path.isdir(file):
            require(os.path.isfile(file), path, "file", uri, "is not a regular file")
            check_regular(file)


def _check_and_list_uris(path: Path, root: ET.Element) -> tuple[str, ...]:
    """Checks numbers and links of a model, and returns the names of meshes and models in it."""
    check_numbers(path, root)
    for model in root.iter("model") if root.tag == "sdf" else (root,):
        _check_tree(path, model)
    filenames = [element.get("filename", "") for element in root.iter()]
    texts = [element.text or "" for element in root.iter("uri")]
    return tuple(dict.fromkeys(uri for text in [*filenames, *texts] if (uri := text.strip())))


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


def check_numbers(where: Path | str, root: ET.Element) -> None:
    """Checks all numbers of a URDF or SDFormat file, from its root element.

    Raises:
        InputError: for the first that is not a finite number, is one too many or missing, or fits no shape or axis.
    """
    _check_numbers_inside(where, root, root.tag == "sdf")


def _check_numbers_inside(where: Path | str, element: ET.Element, is_sdf: bool) -> None:
    has_axis = is_sdf or element.tag != "joint" or element.get("type") not in WITHOUT_AXIS
    for child in element:
        if isinstance(child.tag, str) and (has_axis or child.tag != "axis"):  # a comment has no text as its tag
            inside = f"{where}: {child.tag} '{child.get('name')}'" if child.tag in _NAMED_TAGS else where
            for field, text, counts in _number_texts(child, is_sdf):
                _check_number(inside, field, text, counts)
            _check_numbers_inside(inside, child, is_sdf)


def _number_texts(element: ET.Element, is_sdf: bool) -> Iterator[tuple[str, str, tuple[int, ...]]]:
    """Fields of an element, their texts, and how many numbers these may hold."""
    tag, drake_name = element.tag, element.tag.removeprefix(DRAKE)
    if is_sdf and tag in _SDF_COUNTS and len(element) == 0:
        yield tag, element.text or "", _SDF_COUNTS[tag]
    for name, counts in () if is_sdf else _URDF_COUNTS.get(tag, {}).items():
        if (text := element.get(name)) is not None:
            yield f"{tag}.{name}", text, counts
    if tag != drake_name and drake_name in _DRAKE_FIELDS:
        yield f"drake:{drake_name}", element.get("value", element.text or ""), (1,)


def _check_number(where: Path | str, field: str, text: str, counts: tuple[int, ...]) -> None:
    if field.removeprefix("limit.") in _LIMIT_FIELDS:
        if np.isinf(read_numbers(where, field, text, *counts)).any() and field.startswith("limit."):
            raise InputError(where, field, text, "give a finite number, or leave it out: Drake reads no other in URDF")
        return
    numbers = finite_numbers(where, field, text, *counts, least=0.0 if field in _ROUNDED_FIELDS else LEAST)
    if field in _SIZE_FIELDS and not all(_MIN_SIZE <= number <= _MAX_SIZE for number in numbers):
        raise InputError(where, field, text, f"give sizes from {_MIN_SIZE:g} to {_MAX_SIZE:g} m")
    if field in _NONZERO_FIELDS and not any(numbers):
        raise InputError(where, field, text, "give numbers of which one at least is not 0")
    if field in ("mass", "mass.value") and numbers[0] < 0:
        raise InputError(where, field, text, "give a mass of at least 0, kg")
