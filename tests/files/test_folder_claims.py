"""One process at a time writes to a folder."""

import subprocess
import sys

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.output import claim_folder, release_folders

CLAIM = (
    "import sys; from pathlib import Path; from soft_gripper.files.output import claim_folder; claim_folder(Path('.'))"
)


@pytest.fixture(autouse=True)
def _release():
    yield
    release_folders()


def test_another_process_is_refused_until_the_folder_is_released(tmp_path):
    def claim_elsewhere():
        return subprocess.run([sys.executable, "-c", CLAIM], cwd=tmp_path, capture_output=True, text=True, check=False)

    claim_folder(tmp_path)
    claim_folder(tmp_path)  # again, by whom it is claimed
    assert "another soft-gripper writes there" in claim_elsewhere().stderr
    release_folders()
    assert claim_elsewhere().returncode == 0
    assert list(tmp_path.iterdir()) == []


def test_a_process_that_ends_leaves_no_claim(tmp_path):
    subprocess.run([sys.executable, "-c", CLAIM], cwd=tmp_path, check=True)
    try:
        claim_folder(tmp_path)
    except InputError:
        pytest.fail("the claim is still there")
