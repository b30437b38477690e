"""The notebooks: they run from top to bottom, define nothing, and are kept without outputs."""

import ast
import sys
from importlib import import_module
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpecManager
from jupyter_client.manager import AsyncKernelManager
from nbclient import NotebookClient
from nbformat import NotebookNode

NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))
EXAMPLES = sorted((Path(__file__).parents[2] / "examples" / "own_diagram").glob("*.py"))
DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def notebook(request: pytest.FixtureRequest) -> NotebookNode:
    """Every notebook."""
    return nbformat.read(request.param, as_version=4)


def code_cells(notebook: NotebookNode) -> list[NotebookNode]:
    return [cell for cell in notebook.cells if cell.cell_type == "code"]


def parsed(notebook: NotebookNode) -> list[ast.Module]:
    """The code of every cell, without the lines that are Jupyter's own."""
    sources = (cell.source.splitlines() for cell in code_cells(notebook))
    return [ast.parse("\n".join(line for line in lines if not line.startswith("%"))) for lines in sources]


def test_there_are_notebooks() -> None:
    assert NOTEBOOKS


@pytest.mark.slow
def test_runs_from_top_to_bottom(notebook: NotebookNode, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONPATH", str(NOTEBOOKS[0].parents[1] / "examples"))  # ../examples, were it run at its place
    # Without folders to search there is no kernel but the one of the Python that runs the tests.
    specs = KernelSpecManager(kernel_dirs=[])
    kernel = AsyncKernelManager(kernel_name="python3", kernel_spec_manager=specs)
    assert kernel.kernel_spec.argv[0] == sys.executable
    place = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=300, km=kernel, resources=place).execute(cleanup_kc=True)
    assert not list(tmp_path.iterdir()), "a notebook leaves no files behind"


def test_imports_narrowly(notebook: NotebookNode) -> None:
    assert not [cell.source for cell in code_cells(notebook) if "pydrake.all" in cell.source]


def test_defines_nothing(notebook: NotebookNode) -> None:
    """But blocks of a user's own, just as they stand in the files of examples/own_diagram."""
    shown = [ast.dump(tree) for path in EXAMPLES for tree in ast.walk(ast.parse(path.read_text()))]
    found = [node for tree in parsed(notebook) for node in ast.walk(tree) if isinstance(node, DEFINITIONS)]
    assert not [ast.unparse(node) for node in found if ast.dump(node) not in shown]


def test_holds_no_outputs(notebook: NotebookNode) -> None:
    assert not any(cell.outputs or cell.execution_count is not None for cell in code_cells(notebook))


def test_is_valid(notebook: NotebookNode) -> None:
    nbformat.validate(notebook)


def test_uses_public_names_only(notebook: NotebookNode) -> None:
    nodes = [node for tree in parsed(notebook) for node in ast.walk(tree)]
    modules = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    assert not [module for module in modules if module.startswith("soft_gripper.")]
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("soft_gripper"):
            assert {alias.name for alias in node.names} <= set(import_module(node.module or "").__all__)
