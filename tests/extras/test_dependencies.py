"""What the installed package imports is what it declares, with lower bounds."""

import ast
import re
import sys
import tomllib
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
OWN = "soft_gripper"
FOLDERS = [OWN, "diagrams", "models"]  # rglob does not follow the links to the others
OF_LEARNING = {"gymnasium", "cma"}  # which everything below `learning` needs, and nothing else


def distribution(requirement):
    """The name in a requirement, as the index of packages compares names."""
    return re.split(r"[^\w.-]", requirement)[0].lower().replace("_", "-")


def imported(node):
    """The packages of others that are imported in a piece of a program."""
    for part in ast.walk(node):
        if isinstance(part, ast.Import):
            yield from (name.name.split(".")[0] for name in part.names)
        elif isinstance(part, ast.ImportFrom) and part.level == 0:
            yield part.module.split(".")[0]


def imports(always):
    """Distributions that are imported: at the top of a file outside of `learning`, or anywhere."""
    found = set()
    for file in (file for folder in FOLDERS for file in (ROOT / folder).rglob("*.py")):
        tree = ast.parse(file.read_text())
        nodes = [node for node in tree.body if isinstance(node, ast.Import | ast.ImportFrom)] if always else [tree]
        if not (always and "learning" in file.relative_to(ROOT).parts):
            found |= {name for node in nodes for name in imported(node)}
    names = packages_distributions()
    others = found - {OWN} - set(sys.stdlib_module_names)
    return {min(names.get(name, [name]), key=len).lower() for name in others}  # mujoco, rather than mujoco-core


def test_what_is_always_imported_is_required():
    required = set(map(distribution, PROJECT["project"]["dependencies"]))
    found = imports(always=True) - OF_LEARNING
    assert len(found) > 5
    assert found - required == set()
    by_others = {"pycollada", "h5netcdf"}  # trimesh and xarray
    assert required - found <= by_others | {"shtab", "h5py"}  # the last where they are used


def test_whatever_is_imported_is_declared():
    extras = PROJECT["project"]["optional-dependencies"].values()
    declared = [*PROJECT["project"]["dependencies"], *chain.from_iterable(extras)]
    assert imports(always=False) - set(map(distribution, declared)) == set()


def test_everything_that_is_required_has_a_lower_bound():
    assert [each for each in PROJECT["project"]["dependencies"] if ">=" not in each] == []


def test_every_file_that_states_the_version_states_the_same():
    stated = {"pyproject.toml": PROJECT["project"]["version"]}
    stated["CITATION.cff"] = re.search(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(), re.M)[1]
    for package in chain((ROOT / "models").glob("package.xml"), (ROOT / "soft_gripper/extras").rglob("package.xml")):
        stated[package.parent.name] = re.search("<version>(.+)</version>", package.read_text())[1]
    stated["CHANGELOG.md"] = re.search(r"^## (\d.+) - ", (ROOT / "CHANGELOG.md").read_text(), re.M)[1]
    assert len(set(stated.values())) == 1, stated
