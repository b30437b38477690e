"""Mesh files, checked before trimesh or Drake reads them: neither limits what it reads, and Drake's checks are few."""

import binascii
import os
import re
import struct
from collections.abc import Mapping, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import unquote

from soft_gripper.errors import InputError
from soft_gripper.files.json_text import parse_json
from soft_gripper.files.text import check_regular, read_bytes

MESH_SUFFIXES = (".obj", ".stl", ".dae", ".ply", ".off", ".gltf", ".glb", ".msh", ".vtk")
_MAX_SIZE = 2**25  # bytes of a mesh file, or one that it names: over half a million faces of an STL file
_MAX_GROUPS = 5000  # of an OBJ file; trimesh makes a mesh of each
_MAX_LINE = 2**14  # characters of an OBJ file: a face of over 1000 vertices, of which triangles are made
_GROUP_PATTERN = re.compile(rb"^\s*(?:o|g|usemtl)\s", re.MULTILINE)
_FILE_PATTERNS = {
    ".obj": re.compile(rb"^\s*mtllib\s+(.*\S)", re.MULTILINE),
    ".mtl": re.compile(rb"^\s*(?:map_\w+|bump|disp|decal|refl|norm)\s+(?:.*\s)?(\S+)", re.MULTILINE),
}
_COMPONENT_BYTES = {5120: 1, 5121: 1, 5122: 2, 5123: 2, 5125: 4, 5126: 4}  # bytes
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT2": 4, "MAT3": 9, "MAT4": 16}  # numbers


def check_mesh_file(path: Path) -> None:
    """Raises an InputError if a file is no mesh, or reading it, or what it names, would fail or take minutes."""
    if not os.path.isfile(path):
        raise InputError(path, "mesh", path.name, "there is no such file")
    if path.suffix.lower() not in MESH_SUFFIXES:
        raise InputError(path, "mesh", path.name, f"give a file of one of these kinds: {', '.join(MESH_SUFFIXES)}")
    check_regular(path, _MAX_SIZE)
    _check_content(path, path.stat().st_mtime_ns)


@lru_cache(maxsize=256)
def _check_content(path: Path, modified: int) -> None:
    """Checks the content of a mesh file; `modified`, ns: a changed file is read again."""
    suffix = path.suffix.lower()
    if suffix in (".gltf", ".glb"):
        _check_gltf(path)
    elif suffix == ".obj":
        content = read_bytes(path)
        for quantity, count, max_count in (
            ("groups", len(_GROUP_PATTERN.findall(content)), _MAX_GROUPS),
            ("longest line", max(map(len, content.splitlines()), default=0), _MAX_LINE),
        ):
            if count > max_count:
                raise InputError(path, quantity, count, f"must be at most {max_count}")
        for library in _FILE_PATTERNS[suffix].findall(content):
            if (materials := named_file(path, os.fsdecode(library))).is_file():
                for name in _FILE_PATTERNS[".mtl"].findall(read_bytes(materials)):
                    named_file(materials, os.fsdecode(name))


def named_file(path: Path, name: str) -> Path:
    """The file that a mesh file names, if any; raises an InputError if it is a pipe or a device, or too large."""
    file = path.parent / name
    if os.path.exists(file):
        if not os.path.isfile(file):
            raise InputError(path, "file", name, "is not a regular file")
        check_regular(file, _MAX_SIZE)
    return file


class _Gltf:
    """JSON of a glTF file; its entries refer to each other by index."""

    def __init__(self, path: Path, content: Mapping[str, Any]):
        self._path, self.content = path, content

    def refuse(self, field: str, value: object, expected: str) -> NoReturn:
        raise InputError(self._path, field, value, expected)

    def entries(self, name: str) -> Sequence[Mapping[str, Any]]:
        return self.objects(name, self.content.get(name, []))

    def objects(self, field: str, entries: Any, least: int = 0) -> Sequence[Mapping[str, Any]]:
        is_list = isinstance(entries, list) and len(entries) >= least
        if not is_list or not all(isinstance(entry, dict) for entry in entries):
            self.refuse(field, entries, "must be a list of objects")
        return entries

    def count(self, entry: Mapping[str, Any], field: str, default: int | None = None, least: int = 0) -> int:
        value = entry.get(field, default)
        if type(value) is not int or value < least:
            self.refuse(field, value, f"give a whole number of at least {least}")
        return value

    def find_entry(self, entry: Mapping[str, Any], field: str, name: str) -> Mapping[str, Any]:
        entries = self.entries(name)
        index = self.count(entry, field)
        if index >= len(entries):
            self.refuse(field, index, f"there are {len(entries)} {name}")
        return entries[index]

    def check_entries(self, entry: Mapping[str, Any], names: Mapping[str, str]) -> None:
        """Checks the lists to which fields of an entry refer, as far as it has these."""
        for field, name in names.items():
            if field in entry:
                self.find_entry(entry, field, name)

    def indices(self, entry: Mapping[str, Any], field: str) -> list[int]:
        indices = entry.get(field, [])
        if not isinstance(indices, list):
            self.refuse(field, indices, "must be a list of numbers")
        for index in indices:
            self.find_entry({field: index}, field, "nodes")
        return indices


def _check_gltf(path: Path) -> None:
    """Checks that all that a glTF file refers to is there, and that its nodes are a tree."""
    content, binary = _parts(path, read_bytes(path))
    try:
        document = parse_json(path, content)
    except InputError as error:
        raise InputError(path, "mesh", path.name, f"is not glTF: {error.expected}") from None
    gltf = _Gltf(path, document if isinstance(document, dict) else {})
    asset = gltf.content.get("asset")
    version = str(asset.get("version", "")) if isinstance(asset, dict) else ""
    if not version.startswith("2."):
        gltf.refuse("asset.version", version, "must be 2.0")
    sizes = [_buffer_size(gltf, path, buffer, binary) for buffer in gltf.entries("buffers")]
    for view in gltf.entries("bufferViews"):
        gltf.find_entry(view, "buffer", "buffers")
        begin, length = gltf.count(view, "byteOffset", 0), gltf.count(view, "byteLength", least=1)
        if begin + length > sizes[view["buffer"]]:
            gltf.refuse("bufferView.byteLength", length, f"its buffer ends at {sizes[view['buffer']]} bytes")
        if gltf.count(view, "byteStride", 0) > 252:
            gltf.refuse("bufferView.byteStride", view["byteStride"], "give at most 252")
    for accessor in gltf.entries("accessors"):
        _check_accessor(gltf, accessor)
    for image in gltf.entries("images"):
        if not (uri := str(image.get("uri", "data:"))).startswith("data:"):
            named_file(path, unquote(uri))
    for mesh in gltf.entries("meshes"):
        _check_mesh(gltf, mesh)
    _check_tree(gltf)


def _parts(path: Path, data: bytes) -> tuple[bytes, int]:
    """The JSON of a file, and the size of the buffer in a binary one, bytes."""
    if not data.startswith(b"glTF"):
        return data, 0
    try:
        length, kind = struct.unpack_from("<II", data, 12)
        rest = data[20 + length :]
        binary = struct.unpack_from("<I", rest)[0] if rest else 0
    except struct.error:
        raise InputError(path, "mesh", path.name, "is not glTF: it is too short") from None
    if kind != 0x4E4F534A or length > len(data) - 20 or binary > max(len(rest) - 8, 0):
        raise InputError(path, "mesh", path.name, "is not glTF: its parts are longer than the file")
    return data[20 : 20 + length], binary


def _buffer_size(gltf: _Gltf, path: Path, buffer: Mapping[str, Any], binary: int) -> int:
    size, uri = gltf.count(buffer, "byteLength", least=1), buffer.get("uri")
    data_size = binary
    if isinstance(uri, str) and uri.startswith("data:"):
        try:
            data_size = len(binascii.a2b_base64(uri.partition(",")[2]))
        except binascii.Error:
            data_size = 0
    elif isinstance(uri, str):
        file = named_file(path, unquote(uri))
        data_size = file.stat().st_size if file.is_file() else 0
    if size > data_size:
        gltf.refuse("buffer.byteLength", size, f"its data are {data_size} bytes")
    return size


def _check_accessor(gltf: _Gltf, accessor: Mapping[str, Any]) -> None:
    component, kind = accessor.get("componentType"), accessor.get("type")
    if not (isinstance(component, int) and component in _COMPONENT_BYTES and isinstance(kind, str) and kind in _WIDTHS):
        gltf.refuse("accessor.type", [component, kind], "is no type of glTF")
    if "sparse" in accessor:
        gltf.refuse("accessor.sparse", accessor["sparse"], "leave it out, and give all values")
    view = gltf.find_entry(accessor, "bufferView", "bufferViews")
    count = gltf.count(accessor, "count", least=1)
    width = _COMPONENT_BYTES[component] * _WIDTHS[kind]
    stride = max(gltf.count(view, "byteStride", 0), width)
    if gltf.count(accessor, "byteOffset", 0) + (count - 1) * stride + width > view["byteLength"]:
        gltf.refuse("accessor.count", count, f"its bufferView has {view['byteLength']} bytes")


def _check_mesh(gltf: _Gltf, mesh: Mapping[str, Any]) -> None:
    for part in gltf.objects("mesh.primitives", mesh.get("primitives"), least=1):
        attributes = part.get("attributes")
        if not isinstance(attributes, dict) or "POSITION" not in attributes:
            gltf.refuse("primitive.attributes", attributes, "give a POSITION")
        if gltf.find_entry(attributes, "POSITION", "accessors")["type"] != "VEC3":
            gltf.refuse("primitive.attributes.POSITION", attributes["POSITION"], "must be an accessor of type VEC3")
        gltf.check_entries(attributes, dict.fromkeys(attributes, "accessors"))
        gltf.check_entries(part, {"indices": "accessors", "material": "materials"})


def _check_tree(gltf: _Gltf) -> None:
    nodes, parents = gltf.entries("nodes"), set[int]()
    for node in [*nodes, *gltf.entries("scenes")]:
        gltf.check_entries(node, {"mesh": "meshes", "camera": "cameras", "skin": "skins"})
    for node in nodes:
        for child in gltf.indices(node, "children"):
            if child in parents:
                gltf.refuse("node.children", child, "is a child of two nodes; nodes must be a tree")
            parents.add(child)
    for scene in gltf.entries("scenes"):
        for root in gltf.indices(scene, "nodes"):
            if root in parents:
                gltf.refuse("scene.nodes", root, "is a child of a node; nodes must be a tree")
