"""Runs notebooks and keeps their outputs in them: `python docs/site/store_outputs.py [NOTEBOOK ...]`, all by default.

With its outputs a notebook keeps a digest of its code, by which outputs of other code are recognized.
"""

import base64
import hashlib
import io
import os
import sys
from pathlib import Path

import nbformat
from links import ROOT
from nbclient import NotebookClient
from nbformat import NotebookNode
from PIL import Image

NOTEBOOKS = sorted((ROOT / "notebooks").glob("*.ipynb"))
DIGEST = "outputs_of"  # in the metadata of a notebook
_COLORS = 256  # of a stored figure, which makes it four times as small
_WIDEST = 1000  # pixels of a stored figure: a page is narrower


def code_cells(notebook: NotebookNode) -> list[NotebookNode]:
    """The cells that run."""
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def digest(notebook: NotebookNode) -> str:
    """Of the code of all cells."""
    return hashlib.sha256("\0".join(cell.source for cell in code_cells(notebook)).encode()).hexdigest()


def store(path: Path) -> None:
    """Runs a notebook in its folder, and writes it with its outputs."""
    notebook = nbformat.read(path, as_version=4)
    place = {"metadata": {"path": str(path.parent)}}
    NotebookClient(notebook, timeout=300, resources=place, record_timing=False, coalesce_streams=True).execute()
    for cell in code_cells(notebook):
        cell.outputs = [output for output in cell.outputs if output.get("name") != "stderr"]  # notes of this machine
        for output in cell.outputs:
            if "image/png" in output.get("data", {}):
                output.data["image/png"] = _smaller(output.data["image/png"])
    notebook.metadata = {**notebook.metadata, "language_info": {"name": "python"}, DIGEST: digest(notebook)}
    nbformat.write(notebook, path)


def _smaller(png: str) -> str:
    """A figure no wider than a page, with a palette; both in base 64."""
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    picture.thumbnail((_WIDEST, picture.height))
    written = io.BytesIO()
    picture.quantize(_COLORS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).save(written, "png", optimize=True)
    return base64.b64encode(written.getvalue()).decode()


if __name__ == "__main__":
    os.environ.pop("SOFT_GRIPPER_DATA", None)  # a reader has no recordings
    for chosen in map(Path, sys.argv[1:]) if sys.argv[1:] else NOTEBOOKS:
        store(chosen.resolve())
        print(f"{chosen.name}: {chosen.stat().st_size / 1e3:.0f} kB")
