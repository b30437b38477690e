"""Nothing that a stranger writes ends in a traceback, a crash, a hang, or without a word.

The inputs follow from a fixed seed. `make fuzz` tries many more, from a new seed every time.
"""

import os
import re
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from inputs import KINDS, Input
from sandbox import Ended, Sandbox
from shapes import SHAPES

NUMBER = int(os.environ.get("FUZZ", "0"))  # inputs of every kind; 0: few, and always the same
LIMIT = 120.0  # s of a call, which takes a tenth of a second as a rule: the machine may be busy
LONGEST = 3000  # characters of a complaint
RAW = re.compile(r"Traceback|^\w*Warning\b|^WARNING|^ERROR|^INFO|\bcore dumped", re.MULTILINE)
OURS = "note: ", "soft-gripper: ", "soft-gripper ", "usage: ", " ", "2 fingers, ", "Recording", "Readings: "
OURS += (
    "The last recording ",
    "left_finger: ",
    "right_finger: ",
    "The first malformed message ",
    "Oldest command in force: ",
    "From a reading ",
    "Open http",
    "Rejected ",
)
PROFILE = settings(
    max_examples=NUMBER or 8,
    derandomize=not NUMBER,
    database=None,
    deadline=None,
    phases=[Phase.generate, Phase.shrink] if NUMBER else [Phase.generate],
    suppress_health_check=list(HealthCheck),
    print_blob=True,
)


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    sandbox = Sandbox()
    yield sandbox
    sandbox.close()


def fault(found: Input, ended: Ended, left: set[str]) -> str | None:
    """What is wrong with how a command ended."""
    lines = ended.err.splitlines()
    if ended.code is None:
        return f"ran for more than {LIMIT:g} s"
    if ended.code not in (0, 1, 2):
        return f"exit code {ended.code}"
    if raw := RAW.search(ended.err):
        return f"raw words: {raw[0]}"
    if any(not line.startswith(OURS) for line in lines):
        return "a line that is not ours"
    if ended.code == 2 and not (lines and lines[-1].startswith("soft-gripper")):
        return "refused without a word"
    if ended.code == 2 and ": " not in lines[-1].removeprefix("soft-gripper: "):
        return "refused without naming what"
    if ended.code == 2 and left:
        return f"refused, and yet it left {sorted(left)}"
    return "a complaint without end" if len(ended.err) > LONGEST else None


def run(found: Input, sandbox: Sandbox) -> tuple[Ended, str | None]:
    """Tries an input in a folder of its own."""
    with tempfile.TemporaryDirectory(prefix="fuzz-") as name:
        folder = Path(name)
        (folder / "folder").mkdir()
        for file, content in found.files.items():
            if isinstance(content, str):
                (folder / file).symlink_to(content)
            elif isinstance(content, int):
                with (folder / file).open("wb") as opened:
                    opened.truncate(content)
            else:
                (folder / file).write_bytes(content)
        ended = sandbox.call(found.arguments, folder, LIMIT)
        left = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()} - set(found.files)
    return ended, fault(found, ended, left)


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_hostile_input(kind: str, sandbox: Sandbox) -> None:
    @PROFILE
    @given(found=KINDS[kind]())
    def try_one(found: Input) -> None:
        ended, wrong = run(found, sandbox)
        assert wrong is None, f"{wrong}\n{found.arguments}\n{ended}"

    try_one()


CPU, EXTRA_MEMORY = 2.0, 500.0  # s, MB: what refusing a file may cost beyond the start of the program


@pytest.fixture(scope="module")
def start(sandbox: Sandbox) -> Ended:
    return sandbox.call(["--version"], Path())


@pytest.mark.parametrize(("door", "shape"), [(door, shape) for door, shapes in SHAPES.items() for shape in shapes])
def test_shapes_without_an_end(door: str, shape: str, sandbox: Sandbox, start: Ended) -> None:
    """Deep, wide, long, self-including and endless files are refused, or read, soon and in little memory."""
    ended, wrong = run(SHAPES[door][shape](), sandbox)
    assert wrong is None, f"{wrong}\n{ended}"
    assert ended.cpu < CPU, ended
    assert ended.memory - start.memory < EXTRA_MEMORY, ended


def test_the_fuzz_test_notices(sandbox: Sandbox, tmp_path: Path) -> None:
    """Tracebacks, crashes, hangs and silence are faults; a fine run and a line that names the field are none."""
    fine = Input({}, [])
    assert fault(fine, Ended(0, "", "", 0.1), {"results/a"}) is None
    assert fault(fine, Ended(2, "", "soft-gripper: a.yaml: size = 0: give more\n", 0.1), set()) is None
    for ended in (
        Ended(None, "", "", LIMIT),
        Ended(-6, "", "", 0.1),
        Ended(1, "", "Traceback (most recent call last):\n", 0.1),
        Ended(0, "", "WARNING:drake: x\n", 0.1),
        Ended(0, "", "a.py:1: RuntimeWarning: overflow\n", 0.1),
        Ended(2, "", "", 0.1),
        Ended(2, "", "soft-gripper: no", 0.1),
        Ended(2, "", f"soft-gripper: a: {'x' * 4000}", 0.1),
    ):
        assert fault(fine, ended, set()) is not None
    assert fault(fine, Ended(2, "", "soft-gripper: a.yaml: size = 0: give more\n", 0.1), {"results/a"}) is not None
    assert sandbox.call(["--version"], tmp_path).code == 0
