"""One process at a time writes to a folder."""

import subprocess
import sys

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.output import lock_folder, unlock_folders

CLAIM = (
    "import sys; from pathlib import Path; from soft_gripper.files.output import lock_folder; lock_folder(Path('.'))"
)


@pytest.fixture(autouse=True)
def _release():
    yield
    unlock_folders()


def test_another_process_is_refused_until_the_folder_is_released(tmp_path):
    def lock_elsewhere():
        return subprocess.run([sys.executable, "-c", CLAIM], cwd=tmp_path, capture_output=True, text=True, check=False)

    lock_folder(tmp_path)
    lock_folder(tmp_path)  # again, by the process that holds it
    assert "another soft-gripper writes there" in lock_elsewhere().stderr
    unlock_folders()
    assert lock_elsewhere().returncode == 0
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_ends_leaves_no_claim(tmp_path):
    subprocess.run([sys.executable, "-c", CLAIM], cwd=tmp_path, check=True)
    try:
        lock_folder(tmp_path)
    except InputError:
        pytest.fail("the lock is still there")
