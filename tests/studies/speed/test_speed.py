"""The study of speed: one command for both engines, the time of all processes."""

import subprocess
import sys
from pathlib import Path

import processes
import pytest

from studies.speed import many_grasps


def test_the_page_prints_these_rows():
    page = (Path(__file__).parents[3] / "docs/extras/mujoco_engine/mujoco.md").read_text(encoding="utf-8")
    assert "python -m studies many-grasps --varied" in page
    lines = page.splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith("| varied |")) + 2
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines[start : lines.index("", start)]]
    assert [row[0] for row in rows] == [*many_grasps.VARIED, "designs"]
    for _, runs, mujoco, drake, *a_run, ratio in rows:
        assert float(mujoco) / float(drake) == pytest.approx(float(ratio), abs=0.02)
        assert [float(seconds) / float(runs) for seconds in (mujoco, drake)] == pytest.approx(
            [*map(float, a_run)], abs=0.02
        )


SPIN = "import time\nwhile time.process_time() < 0.4: pass"


def test_the_time_of_processes_that_nobody_waits_for_counts():
    """Such as workers of a fork server, which the system adds to no parent."""
    orphan = f"import subprocess, sys, time; p = subprocess.Popen([sys.executable, '-c', {SPIN!r}]);"
    wait = "\nwhile open(f'/proc/{p.pid}/stat').read().split()[2] != 'Z': time.sleep(0.01)"
    assert processes.cpu_time_of([sys.executable, "-c", orphan + wait + "\nimport os; os._exit(0)"]) > 0.2


def test_a_command_that_fails_has_no_time():
    with pytest.raises(subprocess.CalledProcessError):
        processes.cpu_time_of([sys.executable, "-c", "raise SystemExit(2)"])
