"""The house: which folders there are, and that no import leads upward."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# Each knows those before it, and its own folder.
LAYERS = (
    "models",
    "soft_gripper",  # its own files, that all others know
    "soft_gripper/fingers",
    "soft_gripper/sensors",
    "soft_gripper/shape",
    "soft_gripper/estimators",
    "soft_gripper/estimation",
    "soft_gripper/control",
    "soft_gripper/manipulation",
    "soft_gripper/truth",
    "diagrams/schema",
    "diagrams/loading",
    "diagrams/scene",
    "diagrams/wiring",
    "diagrams/manipulation",
    "diagrams/recording",
    "diagrams/view",
    "diagrams/hardware",
    "diagrams/replay",
    "diagrams",
    "diagrams/live",
    "pictures",
    "evaluation/executor",
    "evaluation",
    "evaluation/paper",
    "evaluation/estimators",
    "evaluation/robustness",
    "evaluation/report",
    "evaluation/trials",
    "evaluation/sweep",
    "evaluation/recognition",
    "evaluation/contacts",
    "evaluation/placement",
    "evaluation/replay",
    "evaluation/identify",
    "evaluation/hardware",
    "learning/schema",
    "learning/station",
    "learning/tasks",
    "learning",
    "learning/gentle_grasp",
    "commands/terminal",
    "commands/hardware",
    "commands/inspect",
    "commands",
)
SOURCES = sorted(path for layer in LAYERS for path in (ROOT / layer).glob("*.py"))
FRONT_DOOR = ROOT / "soft_gripper" / "__init__.py"


def layer_of(module):
    """The place in LAYERS of a module of the package, `soft_gripper.a.b` -> that of the folder `a`."""
    parts = module.split(".")[1:-1]
    own = not parts or (ROOT / "soft_gripper" / parts[0]).is_dir()
    return LAYERS.index("/".join(["soft_gripper", *parts] if own else parts))


def imports(path):
    """Modules of the package that a file imports."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    found = [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    found += [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return [module for module in found if module.startswith("soft_gripper.") and module != "soft_gripper.models"]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_import_leads_upward(path):
    own = LAYERS.index(str(path.parent.relative_to(ROOT)))
    for module in imports(path):
        assert layer_of(module) <= own, module


def test_all_folders_are_in_the_layers():
    found = {
        str(path.parent.relative_to(ROOT))
        for part in ("soft_gripper", "diagrams", "evaluation", "pictures", "learning", "commands", "models")
        for path in (ROOT / part).rglob("*.py")
    }
    assert found - {"models/objects"} == set(LAYERS)
