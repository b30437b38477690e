"""`make test-all`: all suites run, whatever comes of the first."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def make(*arguments: str, **variables: object) -> subprocess.CompletedProcess[str]:
    """Runs make with the environment of these tests in the place of .venv, also where make runs these tests."""
    outer = ("MAKE", "MFLAGS", "NPY_DISABLE")
    command = ["make", "-s", "-o", ".venv/ready", *arguments, f"BIN={Path(sys.executable).parent}"]
    return subprocess.run(
        [*command, *(f"{name}={value}" for name, value in variables.items())],
        cwd=ROOT,
        env={name: value for name, value in os.environ.items() if not name.startswith(outer)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize(("newer", "older"), [(0, 0), (1, 0), (0, 1)])
def test_a_failure_on_the_newer_python_does_not_hide_the_older_one(newer, older):
    ended = make(
        "test-all",
        SUITES="test test-older",
        PYTEST=f"python -c 'raise SystemExit({newer})'",
        OLDER="python",
        LOCKED="true",
        TEST_CORE=f"echo tests of the core; exit {older}",
    )
    assert "tests of the core\n" in ended.stdout
    assert re.findall("^Failed: (.*)$", ended.stdout, re.M) == newer * ["test"] + older * ["test-older"]
    assert ended.returncode == (2 if newer or older else 0)
