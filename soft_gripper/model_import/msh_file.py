"""Meshes in MuJoCo's own binary format, .msh."""

from pathlib import Path

import numpy as np
import trimesh

from soft_gripper.errors import InputError
from soft_gripper.files.text import read_bytes

_HEADER_BYTES = 16  # bytes: the numbers of vertices, normals, points of textures and faces


def read_msh(path: Path) -> trimesh.Trimesh:
    """Reads the mesh of a file.

    Raises:
        InputError: if its size is not what its head says, or a face has a vertex that does not exist.
    """
    content = read_bytes(path)
    counts = np.frombuffer(content[:_HEADER_BYTES].ljust(_HEADER_BYTES, b"\0"), "<i4").astype(int)
    vertices, normals, points, faces = counts
    begin = _HEADER_BYTES + 12 * vertices + 12 * normals + 8 * points
    if counts.min() < 0 or len(content) != begin + 12 * faces:
        raise InputError(
            path, "mesh", path.name, "is damaged, or not a mesh of MuJoCo: its size is not as its head says"
        )
    places = np.frombuffer(content, "<f4", 3 * vertices, _HEADER_BYTES).reshape(-1, 3)
    corners = np.frombuffer(content, "<i4", 3 * faces, begin).reshape(-1, 3)
    if not np.isfinite(places).all() or ((corners < 0) | (corners >= vertices)).any():
        raise InputError(path, "mesh", path.name, "is damaged: a face has no place")
    return trimesh.Trimesh(places.astype(float), corners, process=False)
