"""The processes on this machine, from /proc."""

import resource
from pathlib import Path
from typing import NamedTuple


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
