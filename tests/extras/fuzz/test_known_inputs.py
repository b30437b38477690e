"""Known bad input: one line that names what is wrong and where, exit code 2, and nothing printed or written."""

import os
from pathlib import Path

import pytest
from known_inputs import CASES, FILES
from refusals import refusal


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The present folder, with the files."""
    monkeypatch.chdir(tmp_path)
    for name, content in FILES.items():
        Path(name).write_bytes(content if isinstance(content, bytes) else content.encode())
    Path("folder").mkdir()
    Path("loop.urdf").symlink_to("loop.urdf")
    os.mkfifo("pipe.urdf")
    return tmp_path


@pytest.mark.parametrize("command", CASES, ids=lambda command: " ".join(command)[:80])
def test_is_refused(command: tuple[str, ...], here: Path) -> None:
    said, line = CASES[command], refusal(*(word.replace("{here}", str(here)) for word in command))
    for part in [said] if isinstance(said, str) else said:
        assert part in line
