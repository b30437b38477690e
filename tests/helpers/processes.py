"""The processes on this machine, from /proc."""

import os
import resource
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

MOMENT = 0.1  # s


class Process(NamedTuple):
    """A process that is not a zombie."""

    pid: int
    parent: int
    session: int

    def resident(self) -> float:
        """Its memory, MB; 0 if it has ended."""
        try:
            pages = int(Path(f"/proc/{self.pid}/statm").read_text().split()[1])
        except OSError:
            return 0.0
        return pages * resource.getpagesize() / 1e6

    def cpu_time(self) -> float:
        """Its CPU time, s; 0 if it has ended."""
        try:
            times = Path(f"/proc/{self.pid}/stat").read_text().rpartition(")")[2].split()[11:13]
        except OSError:
            return 0.0
        return sum(map(int, times)) / os.sysconf("SC_CLK_TCK")


def processes() -> list[Process]:
    """All of them."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            head, _, rest = stat.read_text().rpartition(")")
        except OSError:  # it has just ended
            continue
        state, parent, _, session = rest.split()[:4]
        if state != "Z":
            found.append(Process(int(head.split()[0]), int(parent), int(session)))
    return found


def family(pid: int) -> list[Process]:
    """A process and all its descendants."""
    everyone = processes()
    kin = {pid}
    while more := {one.pid for one in everyone if one.parent in kin} - kin:
        kin |= more
    return [one for one in everyone if one.pid in kin]


def cpu_time_of(command: Sequence[str]) -> float:
    """Runs a command, without its output; returns the CPU time of all its processes, s, but for their last moment.

    Raises:
        CalledProcessError: if it fails.
    """
    seconds: dict[int, float] = {}
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while running.poll() is None:
        for one in family(running.pid):
            seconds[one.pid] = max(seconds.get(one.pid, 0.0), one.cpu_time())
        time.sleep(MOMENT)
    if running.returncode != 0:
        raise subprocess.CalledProcessError(running.returncode, command)
    return sum(seconds.values())
