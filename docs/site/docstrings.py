"""Adapts the project's docstrings and types for autodoc."""

import re
from typing import Any

import numpy as np
from docutils import nodes
from numpy.typing import NDArray
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.ext.napoleon import GoogleDocstring
from sphinx.util.typing import stringify_annotation

from soft_gripper.arrays import Array, Planar

# Types by the names that the project gives them, instead of those that numpy spells out.
_TYPES = {"Array": Array, "Planar": Planar, "NDArray[int]": NDArray[np.int_], "NDArray[bool]": NDArray[np.bool_]}
_SPELLED = {stringify_annotation(of, "smart"): name for name, of in _TYPES.items()}
_PATH = re.compile(r"~(\w+\.)+")  # of a type, as autodoc hands it to Sphinx, which shows its last part
_TUPLE = re.compile(r"tuple\[~[\w.]+\.(\w+), \.\.\.\]")  # Sphinx shows it unchanged next to a default
_NOUNS = ("property", "attribute", "data")


def setup(app: Sphinx) -> dict[str, Any]:
    """To be loaded with autodoc and napoleon; napoleon's own processing is switched off."""
    app.connect("autodoc-process-docstring", _read_sections)
    app.connect("autodoc-process-signature", _shorten)
    app.connect("doctree-read", _shorten_properties)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _read_sections(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Args, Returns and Raises; not for properties, where napoleon takes the text before a colon for the type."""
    if what not in _NOUNS:
        lines[:] = GoogleDocstring(lines, app.config, app, what, name, of, options).lines()


def _shorten(
    app: Sphinx, what: str, name: str, of: object, options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    if getattr(of, "_is_protocol", False):
        return "", None  # nothing is made from a protocol itself, so that *args, **kwargs would be shown
    return signature and _short(signature), returned and _short(returned)


def _shorten_properties(app: Sphinx, page: nodes.document) -> None:
    """Shortens the types of properties, for which no signature event is sent."""
    for annotation in page.findall(addnodes.desc_annotation):
        for spelled, name in _SPELLED.items():
            if (shown := _PATH.sub("", spelled)) in annotation.astext():
                annotation.children = [nodes.Text(annotation.astext().replace(shown, name))]


def _short(text: str) -> str:
    for spelled, name in _SPELLED.items():
        text = text.replace(spelled, name)
    return _TUPLE.sub(r"tuple[\1, ...]", text)
