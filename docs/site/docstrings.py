"""What autodoc makes of the project's docstrings and types."""

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

# Types by the names that the project gives them, in the place of what numpy spells out.
_TYPES = {"Array": Array, "Planar": Planar, "NDArray[int]": NDArray[np.int_], "NDArray[bool]": NDArray[np.bool_]}
_SPELLED = {stringify_annotation(of, "smart"): name for name, of in _TYPES.items()}
_PATH = re.compile(r"~(\w+\.)+")  # of a type, as autodoc hands it to Sphinx, which shows its last part
_TUPLE = re.compile(r"tuple\[~[\w.]+\.(\w+), \.\.\.\]")  # beside a default Sphinx shows it as it is
_NOUNS = ("property", "attribute", "data")


def setup(app: Sphinx) -> dict[str, Any]:
    """To be loaded beside autodoc and napoleon, which itself is switched off."""
    app.connect("autodoc-process-docstring", _read_sections)
    app.connect("autodoc-process-signature", _shorten)
    app.connect("doctree-read", _shorten_properties)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _read_sections(app: Sphinx, what: str, name: str, of: object, options: object, lines: list[str]) -> None:
    """Args, Returns and Raises; not of properties, in which napoleon takes what stands before a colon for the type."""
    if what not in _NOUNS:
        lines[:] = GoogleDocstring(lines, app.config, app, what, name, of, options).lines()


def _shorten(
    app: Sphinx, what: str, name: str, of: object, options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    if getattr(of, "_is_protocol", False):
        return "", None  # nothing is made from a protocol itself, so that *args, **kwargs would be shown
    return signature and _short(signature), returned and _short(returned)


def _shorten_properties(app: Sphinx, page: nodes.document) -> None:
    """The types of properties, which go past the event of signatures."""
    for annotation in page.findall(addnodes.desc_annotation):
        for spelled, name in _SPELLED.items():
            if (shown := _PATH.sub("", spelled)) in annotation.astext():
                annotation.children = [nodes.Text(annotation.astext().replace(shown, name))]


def _short(text: str) -> str:
    for spelled, name in _SPELLED.items():
        text = text.replace(spelled, name)
    return _TUPLE.sub(r"tuple[\1, ...]", text)
