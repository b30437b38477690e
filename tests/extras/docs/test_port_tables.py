"""The tables of ports: every block of the project, and every port of each."""

import ast
from pathlib import Path

import pytest
from example_blocks import example_blocks
from port_tables import blocks_page

ROOT = Path(__file__).parents[3]
SOURCES = [path for path in (ROOT / "soft_gripper").rglob("*.py") if "learning" not in path.parts]
SOURCES += (ROOT / "diagrams").rglob("*.py")
WITHOUT_PORTS = {"ArrayBlock", "_PathDriveBlock"}  # what blocks are made from
WITHOUT_PORTS |= {"BatchedBlock", "FusedBlock"}  # and what has the ports of others


def classes_of_systems():
    """Names of all classes in the source that are systems."""
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in SOURCES]
    classes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]
    systems = {"LeafSystem", "Diagram", "LinearSystem", "VectorSystem"}
    while True:
        found = systems | {node.name for node in classes if {ast.unparse(base) for base in node.bases} & systems}
        if found == systems:
            return found & {node.name for node in classes}
        systems = found


@pytest.mark.slow
def test_every_block_is_listed():
    shown = {cls.__name__ for cls in example_blocks()}
    assert classes_of_systems() - WITHOUT_PORTS <= shown
    page = blocks_page()
    assert all(f"## {name}\n" in page or f"## [{name}](" in page for name in shown)
