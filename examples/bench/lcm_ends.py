"""Readings and results of a bench over LCM, as the two ends of `soft-gripper live`.

    soft-gripper live SCENARIO --bench BENCH \\
      --source examples/bench/lcm_ends.py:readings --sink examples/bench/lcm_ends.py:publish

Both are `drake.lcmt_drake_signal`, numbers by name, on the channels READINGS and RESULTS of the default URL. Entry i
of a vector is called `{name}[i]`. LCM keeps the newest of several messages that arrive at once.
"""

import time
from collections.abc import Iterator
from functools import cache
from typing import Any

from drake import lcmt_drake_signal
from pydrake.lcm import DrakeLcm

READINGS, RESULTS = "READINGS", "RESULTS"  # channels
WAIT = 5e-4  # s; Drake's HandleSubscriptions stops all threads while it waits, so it is called often instead


def readings() -> Iterator[dict[str, float]]:
    """Generates the messages on the channel of the readings."""
    lcm = DrakeLcm()
    arrived = list[bytes]()
    lcm.Subscribe(READINGS, arrived.append)
    while True:
        if not lcm.HandleSubscriptions(0):
            time.sleep(WAIT)
        for message in arrived:
            signal = lcmt_drake_signal.decode(message)
            yield dict(zip(signal.coord, signal.val, strict=True))
        arrived.clear()


def publish(results: dict[str, Any], channel: str = RESULTS) -> None:
    """Publishes the results of a reading."""
    values: dict[str, float] = {}
    for name, value in results.items():
        is_vector = hasattr(value, "__len__")
        values |= {f"{name}[{i}]": float(entry) for i, entry in enumerate(value)} if is_vector else {name: float(value)}
    signal = lcmt_drake_signal()
    signal.dim, signal.coord, signal.val = len(values), list(values), list(values.values())
    signal.timestamp = time.time_ns() // 1_000_000
    _lcm().Publish(channel, signal.encode())


@cache
def _lcm() -> DrakeLcm:
    return DrakeLcm()
