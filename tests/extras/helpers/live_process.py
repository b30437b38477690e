"""A session of `live` as a process of its own, which is fed at 100 Hz, and the description of its hardware."""

import socket
import subprocess
import time
from collections.abc import Callable

from command_line import LISTENING

NAMES = [*(f"a{i}" for i in range(4)), *(f"b{i}" for i in range(4)), "pa", "pb"]
BENCH = f"""
source: "{{source}}"
sink: "{{sink}}"
format: text
fields: [n, {", ".join(NAMES)}]
count: n
pressure_unit: kPa
safe_command: -5.0e3
send: []
fingers:
  left_finger: {{{{ readings: [a0, a1, a2, a3], pressures: [pa] }}}}
  right_finger: {{{{ readings: [b0, b1, b2, b3], pressures: [pb] }}}}
"""
LIVE = ("live", "tip_distance_steps", "--set", "sensor.sections=2", "--set", "estimator.type=gaussian")
SAFE = "-5,-5"  # kPa


def bench(folder, source="file:readings.csv", sink="file:results.csv"):
    (folder / "bench.yaml").write_text(BENCH.format(source=source, sink=sink))
    (folder / "readings.csv").write_text("".join(line(i) for i in range(30)))


def line(count, **values):
    numbers = dict.fromkeys(NAMES, 0.001) | {"pa": 10.0, "pb": 10.0} | values
    return ",".join(map(str, [count, *numbers.values()])) + "\n"


def free_port():
    """A UDP port that nobody uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return free.getsockname()[1]


class Running:
    """A session as a process, fed at 100 Hz over UDP or by `send`; its results go to standard output, or to `sink`."""

    def __init__(self, folder, *options, stdout=subprocess.PIPE, source=None, sink="stdio:", send=None):
        self.port = free_port()
        bench(folder, source or f"udp://:{self.port}", sink)
        self._send: Callable[[bytes], object] = send or self._over_udp
        command = [*LISTENING, *LIVE, "--bench", "bench.yaml", *options]
        self.process = subprocess.Popen(command, cwd=folder, stdout=stdout, stderr=subprocess.PIPE, text=True)
        self.link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        said = self.process.stderr.readline()
        assert "ms of processor time" in said, said

    def feed(self, seconds, begin=0):
        """When each was sent."""
        began = time.monotonic()
        for i in range(round(100 * seconds)):
            time.sleep(max(0.0, began + 0.01 * i - time.monotonic()))
            self._send(line(begin + i).encode())

    def has_read_all(self):
        """Whether nothing that was sent over UDP still waits for the session, by Linux's table of sockets."""
        with open("/proc/net/udp", encoding="ascii") as table:
            queues = [words[4] for words in map(str.split, table) if words[1].endswith(f":{self.port:04X}")]
        return all(int(queue.partition(":")[2], 16) == 0 for queue in queues)

    def _over_udp(self, message):
        self.link.sendto(message, ("127.0.0.1", self.port))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.link.close()
        self.process.kill()
        self.process.communicate()
