"""One process at a time writes to a folder."""

import subprocess
import sys

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.output import lock_folder, release_folders

CLAIM = (
    "import sys; from pathlib import Path; from soft_gripper.files.output import lock_folder; lock_folder(Path('.'))"
)


@pytest.fixture(autouse=True)
def _release():
    yield
    release_folders()


def test_another_process_is_refused_until_the_folder_is_released(tmp_path):
    def lock_elsewhere():
        return subprocess.run([sys.executable, "-c", CLAIM], cwd=tmp_path, capture_output=True, text=True, check=False)

    lock_folder(tmp_path)
    lock_folder(tmp_path)  # again, by the process that holds it
    assert "another soft-gripper writes there" in lock_elsewhere().stderr
    release_folders()
    assert lock_elsewhere().returncode == 0
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_ends_leaves_no_claim(tmp_path):
    subprocess.run([sys.executable, "-c", CLAIM], cwd=tmp_path, check=True)
    try:
        lock_folder(tmp_path)
    except InputError:
        pytest.fail("the lock is still there")


def test_folders_that_were_made_and_left_empty_go(tmp_path):
    (tmp_path / "old").mkdir()
    filled, *_ = [lock_folder(tmp_path / name) for name in ("new/filled", "new/below/empty", "old", "old/empty")]
    (filled / "table.csv").touch()
    release_folders()
    left = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")}
    assert left == {"old", "new", "new/filled", "new/filled/table.csv"}
