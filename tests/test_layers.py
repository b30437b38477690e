"""The house: its parts, and that no import leads upward, or from the core to an extra."""

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from soft_gripper import extras

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "soft_gripper"
# Each part of the core may import from those before it. The files of `soft_gripper` itself are known by all.
PARTS = (
    "files",
    "model_import",
    "fingers",
    "sensors",
    "estimators",
    "load",
    "control",
    "truth",
    "scenario",
    "diagrams",
    "pictures",
    "runs",
    "commands",
)
# Each extra may import from all of the core, and from these extras.
LISTED: dict[str, set[str]] = {
    "bench": {"hardware", "page"},
    "design": {"grasps", "sweeps"},
    "export": set(),
    "foxglove": set(),
    "grasps": {"sweeps"},
    "hardware": {"page", "sweeps"},
    "health": set(),
    "learning": {"mujoco_engine"},
    "mujoco_engine": {"export"},
    "page": set(),
    "paper": {"sweeps"},
    "play": {"page"},
    "soft": set(),
    "sweeps": set(),
}
EXTRAS = {name: used for name, used in LISTED.items() if (PACKAGE / "extras" / name).is_dir()}  # any may be deleted
LINKED = ROOT / "diagrams", ROOT / "models"
FRONT_DOOR = PACKAGE / "__init__.py"
CORE = sorted(path for part in PARTS for path in (PACKAGE / part).resolve().rglob("*.py"))


def part_of(module):
    """The part that a module of the package is in, by its place in PARTS; -1 for the files that all know."""
    name = module.split(".")[1]
    return PARTS.index(name) if name in PARTS else -1


def extra_of(module):
    """The extra that a module is in; None for the core."""
    parts = module.split(".")
    return parts[2] if parts[1] == "extras" and len(parts) > 2 and parts[2] in LISTED else None


def module_of(path):
    """`soft_gripper.part.file` of a file, wherever the link to its part leads."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts if parts[0] == "soft_gripper" else ("soft_gripper", *parts))


def imports(path):
    """Modules of the package that a file imports."""
    nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
    found = [node.module for node in nodes if isinstance(node, ast.ImportFrom) and node.module]
    found += [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    return [module for module in found if module.startswith(("soft_gripper.", "studies"))]


@pytest.mark.parametrize("path", CORE, ids=lambda path: str(path.relative_to(ROOT)))
def test_no_import_leads_upward(path):
    own = part_of(module_of(path))
    for module in imports(path):
        assert part_of(module) <= own, module


def test_files_that_all_know_import_no_part():
    for path in set(PACKAGE.glob("*.py")) - {FRONT_DOOR}:
        assert [module for module in imports(path) if part_of(module) >= 0] == []


def test_every_folder_is_a_part():
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and path.name != "__pycache__"}
    assert folders - {"models", "extras"} == set(PARTS)
    assert extras.names() == sorted(EXTRAS)


@pytest.mark.parametrize("path", CORE, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_core_names_no_extra(path):
    """In no string either."""
    assert re.findall(rf"\bextras[./]({'|'.join(LISTED)})\b", path.read_text(encoding="utf-8")) == []


def test_nothing_else_imports_a_study():
    """Neither the wheel nor what is beside it: `studies` and its tests may be deleted."""
    beside = (path for folder in ("tests", "examples", "docs/site") for path in (ROOT / folder).rglob("*.py"))
    paths = [*(path for folder in (PACKAGE, *LINKED) for path in folder.rglob("*.py")), *beside]
    others = (path for path in paths if "studies" not in path.relative_to(ROOT).parts)
    assert [str(path) for path in others if any(module.startswith("studies") for module in imports(path))] == []


def test_no_test_of_the_core_names_an_extra():
    """Nor do its helpers: the tests of extras, and of the whole product with them, are in tests/extras."""
    beside = {"extras", "studies"}
    paths = (path for path in (ROOT / "tests").rglob("*.py") if not beside & {*path.relative_to(ROOT).parts})
    named = rf"\bextras[./]({'|'.join(LISTED)})\b"
    assert [str(path) for path in paths if re.search(named, path.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize("name", EXTRAS)
def test_extras_use_each_other_as_listed(name):
    files = (PACKAGE / "extras" / name).rglob("*.py")
    used = {extra_of(module) for path in files for module in imports(path)} - {None, name}
    assert used == EXTRAS[name]


def test_extras_say_for_whom_they_are():
    for name in EXTRAS:
        text = (PACKAGE / "extras" / name / "README.md").read_text(encoding="utf-8")
        assert len(text.splitlines()) <= 30, name
        assert "For " in text, name


def _left_out(folder, names, skipped):
    """The entries of a folder that a copy of the package is to have no part of."""
    return {name for name in names if name == "__pycache__" or f"{folder}/{name}" in skipped}


def test_what_extras_add_is_light():
    """It is imported whenever a scenario is read: it takes no part of the package but the files that all know."""
    for path in (PACKAGE / "extras").glob("*/adds.py"):
        assert [module for module in imports(path) if part_of(module) >= 0 or extra_of(module)] == [], path


@pytest.mark.parametrize("removed", [*EXTRAS, "all"])
def test_the_rest_goes_on_without_an_extra(tmp_path, removed):
    """The command line lists and runs what is left; those that use what is removed are removed with it."""
    gone = {*EXTRAS} if removed == "all" else {removed, *(name for name, used in EXTRAS.items() if removed in used)}
    skipped = {str(PACKAGE / "extras" / name) for name in gone}
    shutil.copytree(
        PACKAGE,
        tmp_path / "soft_gripper",
        ignore=lambda folder, names: _left_out(folder, names, skipped),
    )
    run = "from soft_gripper.commands import main; from soft_gripper import extras; print(extras.names())"
    found = subprocess.run(
        [sys.executable, "-c", f"{run}; main(['--help'])"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr
    assert found.stdout.startswith(str(sorted({*EXTRAS} - gone)))


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """A tree whose only extras are those of the how-to page; the text of the page."""
    folder = tmp_path_factory.mktemp("own")
    others = {str(PACKAGE / "extras" / name) for name in EXTRAS}
    shutil.copytree(PACKAGE, folder / "soft_gripper", ignore=lambda place, names: _left_out(place, names, others))
    page = (ROOT / "docs" / "howto" / "own_extra.md").read_text(encoding="utf-8")
    for name, text in re.findall(r"^```python\n# (soft_gripper/\S+)\n(.*?)^```$", page, re.MULTILINE | re.DOTALL):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    (folder / "soft_gripper/extras/ripeness/__init__.py").touch()
    return folder, page


def _commands(folder, *lines):
    """Runs commands of the package in a folder, one after the other; the exit code is that of the last."""
    run = f"import sys; from soft_gripper.commands import main; sys.exit([main(line) for line in {lines!r}][-1])"
    return subprocess.run([sys.executable, "-c", run], cwd=folder, capture_output=True, text=True, check=False)


def test_an_extra_of_ones_own_is_one_file(own):
    folder, page = own
    (command,) = re.findall(r"^    soft-gripper (closing.*)$", page, re.MULTILINE)
    found = _commands(folder, command.split())
    assert found.returncode == 0, found.stderr
    assert [float(angle) > 5 for angle in re.findall(r"finger +(-?[\d.]+)", found.stdout)] == [True, True]


def test_fields_that_an_extra_adds_are_fields_of_scenarios(own):
    set_to = [["show", "pick_and_place_box", "--set", f"models.3.mesh.ripeness={value}"] for value in (0.7, 7)]
    found = _commands(own[0], *set_to)
    assert "ripeness: 0.7" in found.stdout, found.stderr
    assert (found.returncode, "ripeness = 7" in found.stderr) == (2, True), found.stderr
