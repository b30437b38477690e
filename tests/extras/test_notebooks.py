"""The notebooks: they run from top to bottom, define nothing, and are kept with the outputs of their code."""

import ast
import re
import sys
from importlib import import_module
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbformat import NotebookNode
from store_outputs import DIGEST, NOTEBOOKS, code_cells, digest

LARGEST = 500e3  # bytes of a notebook


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request: pytest.FixtureRequest) -> NotebookNode:
    """Every notebook."""
    return nbformat.read(request.param, as_version=4)


def parsed(notebook: NotebookNode) -> list[ast.Module]:
    """The code of every cell, without the lines that are Jupyter's own."""
    sources = (cell.source.splitlines() for cell in code_cells(notebook))
    return [ast.parse("\n".join(line for line in lines if not line.startswith("%"))) for lines in sources]


def shown(notebook: NotebookNode) -> list[list[str]]:
    """Of each cell the kinds of its outputs, and the words that it prints; numbers need not be the same anywhere."""
    return [
        [*map(" ".join, (sorted(o.data) for o in cell.outputs if "data" in o)), words(cell)]
        for cell in code_cells(notebook)
    ]


def words(cell: NotebookNode) -> str:
    """What a cell prints, without numbers."""
    printed = "".join(output.text for output in cell.outputs if output.get("name") == "stdout")
    return " ".join(re.sub(r"[-+]?\d[\d.e+-]*|nan", "#", printed).split())


@pytest.mark.slow
def test_runs_from_top_to_bottom(notebook: NotebookNode, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("SOFT_GRIPPER_DATA", raising=False)  # outputs are those of a reader without recordings
    monkeypatch.delenv("MPLBACKEND", raising=False)  # which commands set that other tests call
    stored = shown(notebook)
    monkeypatch.setenv("PYTHONPATH", str(NOTEBOOKS[0].parents[1] / "examples"))  # ../examples, were it run at its place
    # Without folders to search there is no kernel but the one of the Python that runs the tests.
    specs = KernelSpecManager(kernel_dirs=[])
    kernel = AsyncKernelManager(kernel_name="python3", kernel_spec_manager=specs)
    assert kernel.kernel_spec.argv[0] == sys.executable
    place = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=300, km=kernel, resources=place).execute(cleanup_kc=True)
    assert shown(notebook) == stored, "make notebooks stores its outputs"
    assert not list(tmp_path.iterdir()), "a notebook leaves no files behind"


def test_imports_narrowly(notebook: NotebookNode) -> None:
    assert not [cell.source for cell in code_cells(notebook) if "pydrake.all" in cell.source]


def test_outputs_are_those_of_its_code(notebook: NotebookNode) -> None:
    """`make notebooks` stores them."""
    assert notebook.metadata[DIGEST] == digest(notebook)
    counts = [cell.execution_count for cell in code_cells(notebook)]
    assert counts == list(range(1, len(counts) + 1))
    assert any("image/png" in kinds for cell in shown(notebook) for kinds in cell)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_is_small_and_knows_no_machine(path: Path) -> None:
    assert path.stat().st_size < LARGEST
    assert not re.findall(r"/(?:home|root|tmp|Users|work)/", path.read_text(encoding="utf-8"))


def test_uses_public_names_only(notebook: NotebookNode) -> None:
    nodes = [node for tree in parsed(notebook) for node in ast.walk(tree)]
    modules = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    assert not [module for module in modules if module.startswith("soft_gripper.")]
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("soft_gripper"):
            assert {alias.name for alias in node.names} <= set(import_module(node.module or "").__all__)


@pytest.mark.parametrize(
    ("stem", "sentence", "printed"),
    [
        ("01_free_bending", "at 210 kPa 0.5 mm at the fingertip", "fingertip, estimated: 0.5 mm off at 210 kPa"),
        (
            "02_contact_and_shape",
            "locate the joints within 1.7 mm, four within 0.4 mm",
            "2: 1.7 mm, 3: 0.8 mm, 4: 0.4 mm",
        ),
        ("04_grip_control", "of which full vacuum reaches 128 mm", "reached: 128 mm"),
        ("04_grip_control", "recovers at once instead of 1.6 s late", "later without: 1.6 s"),
        ("07_estimators", "from 1.5 mm down to 0.0004 mm", "at the end: arcs 1.5 mm, contact 0.0004 mm"),
    ],
)
def test_numbers_of_a_text_are_printed_by_its_code(stem: str, sentence: str, printed: str) -> None:
    (path,) = (path for path in NOTEBOOKS if path.stem == stem)
    notebook = nbformat.read(path, as_version=4)
    texts = " ".join(" ".join(cell.source.split()) for cell in notebook.cells if cell.cell_type == "markdown")
    outputs = "".join(o.text for cell in code_cells(notebook) for o in cell.outputs if o.get("name") == "stdout")
    assert sentence in texts
    assert printed in outputs
