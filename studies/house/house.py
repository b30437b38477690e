"""Prints size and order of the code for `make house`: each measure with its aim, and the growth of the rooms.

Another measure is a line of `measures`. For times see `make bench-against`.
"""

import argparse
import ast
import io
import re
import subprocess
import tarfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from studies import ROOT
from studies.house.words import AIM, word_counts

PRODUCT = "soft_gripper", "diagrams", "models"
EXTRAS = ROOT / "soft_gripper" / "extras"
POOR_BEGINNING = re.compile(r"(Of|The same|What|Those|That of)\b")
OVERUSED_NAMES = "live", "table", "tables", "run", "session", "task"
PLANAR_PATTERN = re.compile(r"\bPlanar\b|\bcomplex\b|\b1j\b|\.imag\b|\.conj\b")
PLANAR_FILES = "estimators/arcs.py", "estimators/arc_shapes.py", "extras/paper"  # where planar mathematics belongs
SHAPE_PATTERN = re.compile(r"class (\w*)(Contact|Gaussian|Recursive)Shape\b")
BLOCK_PATTERN = re.compile(r"class (?!Force)\w*Estimator\((?:ArrayBlock|ShapeEstimator)\)")


def files(*folders: str) -> list[Path]:
    """Python files below folders of the repository."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))


def lines(paths: list[Path]) -> int:
    """Number of lines of files."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in paths)


def docstrings(path: Path) -> Iterator[str]:
    """Docstrings of a module, its classes and functions."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            yield ast.get_docstring(node) or ""


def matches(pattern: re.Pattern[str], paths: list[Path]) -> int:
    """Number of matches of a pattern in files."""
    return sum(len(pattern.findall(path.read_text(encoding="utf-8"))) for path in paths)


def count_extra_names(core: list[Path]) -> int:
    """Number of core files that name an extra as a module."""
    extras = [path.name for path in EXTRAS.iterdir() if path.is_dir()] if EXTRAS.is_dir() else []
    pattern = re.compile(r"extras\.(" + "|".join(extras or ["-"]) + r")\b")
    return sum(bool(pattern.search(path.read_text(encoding="utf-8"))) for path in core)


def measures() -> Iterator[tuple[str, object, str]]:
    """Name, number today and aim of every measure."""
    product = files(*PRODUCT)
    core = [path for path in product if EXTRAS not in path.parents]
    planar = [path for path in core if not any(part in path.as_posix() for part in PLANAR_FILES)]
    modules = Counter(path.stem for path in product)
    yield "lines of Python, product", lines(product), "43,000"
    yield "  of these outside extras", lines(core), "23,000"
    yield "lines of studies", lines(files("studies")), "7,000"
    yield "lines of tests", lines(files("tests")), "38,000"
    yield "words of documentation", sum(word_counts().values()), f"{AIM:,}"
    yield "estimator blocks", matches(BLOCK_PATTERN, core), "2"
    yield "implementations of contact, gaussian, recursive", matches(SHAPE_PATTERN, product), "3"
    yield "files with planar complex arithmetic", sum(bool(matches(PLANAR_PATTERN, [path])) for path in planar), "10"
    yield "core files that name an extra", count_extra_names(core), "0"
    poor = sum(bool(POOR_BEGINNING.match(text)) for path in product for text in docstrings(path))
    yield "docstrings without a subject", poor, "20"
    for name in OVERUSED_NAMES:
        yield f"modules named {name}", modules[name], "1"


def room(path: str) -> str:
    """Room of a file: a folder of the package, an extra, or a folder of the repository."""
    folder, *subfolders = path.split("/")[:-1] or ["top level"]
    depth = 2 if subfolders[:1] == ["extras"] else 1
    name = "/".join([folder, *subfolders[:depth]]) if folder == PRODUCT[0] else folder
    return f"{name}, words" if path.endswith(".md") else f"{name}, lines"


def sizes(revision: str) -> Counter[str]:
    """Lines of Python and words of documentation of every room at a commit."""
    names = "*.py", "docs/*.md", "README.md", "CONTRIBUTING.md"
    archive = subprocess.run(["git", "archive", revision, "--", *names], cwd=ROOT, capture_output=True, check=True)
    sizes: Counter[str] = Counter()
    with tarfile.open(fileobj=io.BytesIO(archive.stdout)) as files:
        for file in filter(tarfile.TarInfo.isreg, files):
            text = files.extractfile(file).read().decode()  # type: ignore[union-attr]
            sizes[room(file.name)] += len(text.split() if file.name.endswith(".md") else text.splitlines())
    return sizes


def revisions() -> Iterator[tuple[str, str]]:
    """Yields names and commits of earlier states, as far as this clone has them."""
    release = re.search(r"^version = .*", (ROOT / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    for name, choice in (
        ("last release", ["-S", release.group() if release else "", "--", "pyproject.toml"]),
        ("a week ago", ["--before=1 week ago"]),
    ):
        log = subprocess.run(["git", "log", "-1", "--format=%h", *choice], cwd=ROOT, capture_output=True, text=True)
        if commit := log.stdout.strip():
            yield name, commit


def run(options: argparse.Namespace) -> None:
    """Prints the tables."""
    print("| measure | today | aim, at most |\n|---|---:|---:|")
    for name, value, aim in measures():
        print(f"| {name} | {value:,} | {aim} |")
    columns = {"last commit": "HEAD", **dict(revisions())}
    print(f"\n| room | {' | '.join(f'{name}, {commit}' for name, commit in columns.items())} |")
    print(f"|---|{len(columns) * '---:|'}")
    counts = [sizes(commit) for commit in columns.values()]
    for name in sorted(set().union(*counts)):
        print(f"| {name} | {' | '.join(f'{count[name]:,}' for count in counts)} |")
