"""The CPU time of a command is that of all its processes."""

import subprocess
import sys

import processes
import pytest

SPIN = "import time\nwhile time.process_time() < 0.4: pass"


def test_the_time_of_processes_that_nobody_waits_for_counts():
    """Such as workers of a fork server, which the system adds to no parent."""
    orphan = f"import subprocess, sys, time; p = subprocess.Popen([sys.executable, '-c', {SPIN!r}]);"
    wait = "\nwhile open(f'/proc/{p.pid}/stat').read().split()[2] != 'Z': time.sleep(0.01)"
    assert processes.cpu_time_of([sys.executable, "-c", orphan + wait + "\nimport os; os._exit(0)"]) > 0.2


def test_a_command_that_fails_has_no_time():
    with pytest.raises(subprocess.CalledProcessError):
        processes.cpu_time_of([sys.executable, "-c", "raise SystemExit(2)"])
