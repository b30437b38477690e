"""The example of a bench over LCM: what is published on a channel arrives by name."""

import time
from pathlib import Path

import pytest

from soft_gripper.extras.bench.endpoints import Endpoints
from soft_gripper.registry import OWN

ENDS = Path(__file__).parents[3] / "examples" / "bench" / "lcm_ends.py"


def test_numbers_arrive_by_name():
    publish = OWN.find(f"{ENDS}:publish", "sink")
    with Endpoints("bench.yaml") as endpoints:
        source, arrived, end = endpoints.source(f"{ENDS}:readings"), [], time.monotonic() + 2.0
        while not arrived and time.monotonic() < end:
            publish({"count": 3, "left_finger.strain": [0.01, -0.02]}, channel="READINGS")
            arrived = source.receive(0.05)
    if not arrived:
        pytest.skip("LCM is not possible here: no message arrives by multicast")
    assert arrived[0] == {"count": 3.0, "left_finger.strain[0]": 0.01, "left_finger.strain[1]": -0.02}
