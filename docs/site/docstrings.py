"""What autodoc makes of signatures: the names of the project's types in the place of what numpy spells out."""

from typing import Any

from sphinx.application import Sphinx

_NAMES = {
    "ndarray[tuple[Any, ...], dtype[float64]]": "Array",
    "ndarray[tuple[Any, ...], dtype[complex128]]": "Planar",
    "ndarray[tuple[Any, ...], dtype[int64]]": "NDArray[int]",
    "ndarray[tuple[Any, ...], dtype[bool]]": "NDArray[bool]",
}


def setup(app: Sphinx) -> dict[str, Any]:
    """Shortens what autodoc writes."""
    app.connect("autodoc-process-signature", _shorten)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _shorten(
    app: Sphinx, what: str, name: str, of: object, options: object, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    return _short(signature), _short(returned)


def _short(text: str | None) -> str | None:
    for spelled, name in _NAMES.items():
        text = text and text.replace(spelled, name)
    return text
