"""The house: its parts, and that no import leads upward."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "soft_gripper"
# Each part may import from those before it. The files of `soft_gripper` itself are known by all.
PARTS = (
    "files",
    "fingers",
    "sensors",
    "estimators",
    "load",
    "control",
    "truth",
    "scenario",
    "recognition",
    "diagrams",
    "pictures",
    "runs",
    "design",
    "export",
    "hardware",
    "play",
    "evaluation",
    "placement",
    "benchmark",
    "learning",
    "commands",
)
FRONT_DOOR = PACKAGE / "__init__.py"
SOURCES = sorted(path for part in PARTS for path in (PACKAGE / part).resolve().rglob("*.py"))


def part_of(module):
    """The part that a module of the package is in, by its place in PARTS; -1 for the files that all know."""
    name = module.split(".")[1]
    return PARTS.index(name) if name in PARTS else -1


def module_of(path):
    """`soft_gripper.part.file` of a file, wherever the link to its part leads."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts if parts[0] == "soft_gripper" else ("soft_gripper", *parts))


def imports(path):
    """Modules of the package that a file imports."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    found = [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    found += [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return [module for module in found if module.startswith("soft_gripper.")]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_import_leads_upward(path):
    own = part_of(module_of(path))
    for module in imports(path):
        assert part_of(module) <= own, module


def test_files_that_all_know_import_no_part():
    for path in set(PACKAGE.glob("*.py")) - {FRONT_DOOR}:
        assert [module for module in imports(path) if part_of(module) >= 0] == []


def test_every_folder_is_a_part():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders - {"models"} == set(PARTS)
