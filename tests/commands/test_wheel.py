"""The wheel: it holds all that the project ships, and works in an environment where the source is not."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from command_line import short

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
NOT_SOURCE = shutil.ignore_patterns(".*", "__pycache__", "build", "dist", "results", "*.egg-info")
SCRIPT = (ROOT / "tests" / "helpers" / "user_script.py").read_text(encoding="utf-8")
MISTAKES = """
sg.nonsense
sg.sensors.nonsense
sg.simulate("free_bending")
sg.simulate(scenario).nonsense
sg.make_station(scenario).fingrs
sg.SensorConfig(sections="two")
station.fingers[0].finger.segments.upper()
"""


def run(*command: object, cwd: Path) -> str:
    """What a command prints; fails with what it complains about."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    arguments = [str(part) for part in command]
    done = subprocess.run(arguments, cwd=cwd, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the sdist, which is built from a copy of the source with its links."""
    folder = tmp_path_factory.mktemp("wheel")
    shutil.copytree(ROOT, folder / "source", symlinks=True, ignore=NOT_SOURCE)
    run(sys.executable, "-m", "build", "--outdir", folder, folder / "source", cwd=folder)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def fresh_venv(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder with the commands of an environment that has the wheel, and borrows Drake and the rest.

    A path that stands in a .pth file adds the packages there, but no editable install of the source.
    """
    folder = tmp_path_factory.mktemp("fresh_venv")
    venv.create(folder, symlinks=True)
    python = folder / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", wheel, cwd=folder)
    (site_packages,) = folder.glob("lib/python*/site-packages")
    (site_packages / "borrowed.pth").write_text(sysconfig.get_path("purelib"))
    return python.parent


def test_wheel_and_sdist_hold_the_files_of_the_source(wheel: Path) -> None:
    walk = os.walk(ROOT / "soft_gripper", followlinks=True)
    files = [Path(folder, name).relative_to(ROOT) for folder, _, names in walk for name in names]
    shipped = {str(file) for file in files if "__pycache__" not in file.parts}
    assert {"soft_gripper/__init__.pyi", "soft_gripper/diagrams/scenarios/free_bending.yaml"} <= shipped
    of_wheel = {name for name in zipfile.ZipFile(wheel).namelist() if name.startswith("soft_gripper/")}
    (sdist,) = wheel.parent.glob("*.tar.gz")
    with tarfile.open(sdist) as archive:
        inside = {member.name.partition("/")[2] for member in archive if member.isfile()}
    assert of_wheel == {name for name in inside if name.startswith("soft_gripper/")} == shipped


def test_its_code_is_what_runs(fresh_venv: Path, tmp_path: Path) -> None:
    files = "(module.__file__ for name, module in sys.modules.items() if 'soft_g' in name)"
    code = f"import sys, soft_gripper.commands.dispatch; print(*{files})"
    files = run(fresh_venv / "python", "-c", code, cwd=tmp_path).split()
    assert len(files) > 10
    assert [file for file in files if not file.startswith(str(fresh_venv.parent))] == []


def test_runs_a_scenario_in_an_empty_folder(fresh_venv: Path, tmp_path: Path) -> None:
    run(fresh_venv / "soft-gripper", "run", "free_bending", *short(), cwd=tmp_path)
    written = {file.name for file in (tmp_path / "results" / "free_bending").iterdir()}
    assert written == {"scenario.yaml", "recording.nc", "metrics.csv", "forces.csv", "success.csv"}


@pytest.fixture(params=["editable", "wheel"])
def python(request: pytest.FixtureRequest) -> Path:
    """The Python of an environment in which the project is installed."""
    if request.param == "editable":
        return Path(sys.executable)
    fresh: Path = request.getfixturevalue("fresh_venv")
    return fresh / "python"


def lines_of_mypy(python: Path, folder: Path) -> set[int]:
    cache = f"--cache-dir={ROOT / '.mypy_cache' / 'user_script'}"  # of packages of others
    (folder / "mypy.ini").write_text(
        "[mypy]\nstrict = true\n[mypy-gymnasium.wrappers.*]\nfollow_imports = skip\n"
    )  # 40 s
    command = [sys.executable, "-m", "mypy", cache, "--python-executable", str(python), "script.py"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=900)
    return set(map(int, re.findall(r"^script\.py:(\d+): error", done.stdout, re.MULTILINE)))


def lines_of_pyright(python: Path, folder: Path) -> set[int]:
    (folder / "pyrightconfig.json").write_text('{"typeCheckingMode": "standard"}')
    command = [sys.executable, "-m", "basedpyright", "--outputjson", "--pythonpath", str(python), "script.py"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)
    found = json.loads(done.stdout)["generalDiagnostics"]
    return {one["range"]["start"]["line"] + 1 for one in found if one["severity"] == "error"}


@pytest.mark.parametrize("lines", [lines_of_mypy, lines_of_pyright])
def test_type_checkers_find_the_mistakes_of_a_user_and_no_others(
    lines: Callable[[Path, Path], set[int]], python: Path, tmp_path: Path
) -> None:
    (tmp_path / "script.py").write_text(SCRIPT + MISTAKES)
    first = len(SCRIPT.splitlines()) + 2
    assert lines(python, tmp_path) == set(range(first, first + len(MISTAKES.split())))


def test_the_script_without_mistakes_runs(fresh_venv: Path, tmp_path: Path) -> None:
    (tmp_path / "script.py").write_text(SCRIPT)
    printed = run(fresh_venv / "python", "script.py", cwd=tmp_path)
    assert "'gaussian': " in printed
    assert {file.name for file in tmp_path.iterdir()} == {"script.py", "errors.png", "free_bending.nc"}
