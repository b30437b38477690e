"""Sessions of `live` that are killed at random moments, or whose device is unplugged: recordings and commands.

KILLS kills and a quarter as many unpluggings, each time at other moments (`make kills`), or a few that are always the
same.
"""

import os
import random
import signal
import socket
import tty

import numpy as np
import pytest
from live_process import SAFE, Running
from waiting import LONG

from soft_gripper.diagrams.recording import Recording

pytest.importorskip("serial")
pytestmark = pytest.mark.slow

KILLS = int(os.environ.get("KILLS", "0"))
RANDOM = random.Random(None if KILLS else 2)
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
LOST = 100  # readings, of the last second that was used: a busy machine may be further behind what was sent
MOMENTS = 0.5, 4.0  # s after the first reading


class Device:
    """A serial port that sends readings, and a socket that takes commands."""

    def __init__(self):
        self.ours, theirs = os.openpty()
        tty.setraw(theirs)
        self.name, self.theirs, self._last = os.ttyname(theirs), theirs, b""
        self.commands = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.commands.bind(("127.0.0.1", 0))
        self.commands.setblocking(False)

    def send(self, message):
        os.write(self.ours, message)
        self.last_command()  # a full buffer would take no more

    def unplug(self):
        os.close(self.ours)
        os.close(self.theirs)

    def last_used(self):
        """Number of the last reading that had a result."""
        number, *_ = self.last_command().split(",")
        return float(number)

    def last_command(self):
        while True:
            try:
                self._last = self.commands.recv(2**16)
            except BlockingIOError:
                return self._last.decode().strip()


def live(folder, device, ending):
    """Runs a session up to a random moment and its ending; returns the numbers of the readings in its recording."""
    port = device.commands.getsockname()[1]
    sink, source = f"udp://127.0.0.1:{port}", f"serial://{device.name}"
    with Running(folder, "--out", "out", source=source, sink=sink, send=device.send) as session:
        session.feed(RANDOM.uniform(*MOMENTS))
        ending(session)
        session.process.wait(LONG)
    counts = Recording.load(folder / "out" / "recording.nc")["reading.count"].values
    return counts[np.isfinite(counts)]


@pytest.mark.parametrize("i", range(KILLS or 2))
def test_a_session_that_is_killed(i, tmp_path):
    number, device = SIGNALS[i % len(SIGNALS)], Device()
    counts = live(tmp_path, device, lambda session: session.process.send_signal(number))
    assert counts[-1] >= device.last_used() - LOST
    if number != signal.SIGKILL:
        assert device.last_command().endswith(SAFE)
    device.unplug()
