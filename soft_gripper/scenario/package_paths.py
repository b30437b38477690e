"""Files in packages, which do not lead out of these."""

import os
import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.document import require

_SCHEMES = ("package://", "model://")


def check_inside(where: object, uri: str) -> None:
    """Looks at a URI of a file in a package, package://NAME/PATH.

    Raises:
        InputError: if its path leads out of the package.
    """
    package, _, inside = uri.partition("://")[2].partition("/")
    stays = os.path.normpath(f"/{package}/{inside}").startswith(f"/{package}/")
    if package in ("", ".", "..") or not stays:
        raise InputError(where, "file", uri, "leads out of the package")


def check_uris(path: Path, root: ET.Element) -> None:
    """Looks at the meshes and models that a URDF or SDFormat file names, in packages wherever these lie, or beside it.

    Raises:
        InputError: if one leads out of its package, or names something, such as a pipe, that is not a file or folder.
    """
    for element in root.iter():
        for text in (element.get("filename", ""), element.text or "" if element.tag == "uri" else ""):
            uri = text.strip()
            if uri.startswith(_SCHEMES):
                check_inside(path, uri)
            elif uri and os.path.exists(file := os.path.join(path.parent, uri.removeprefix("file://"))):
                expected = "is not a regular file"
                require(os.path.isfile(file) or os.path.isdir(file), path, "file", uri, expected)
