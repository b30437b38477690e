import json
import math
from queue import Queue

from soft_gripper.diagrams.live.signal_feed import SignalFeed

KNOWN = ("a", "b")


def messages(queue: "Queue[str | None]") -> list:
    found = []
    while not queue.empty():
        message = queue.get()
        found.append(message if message is None else json.loads(message))
    return found


def test_everybody_gets_what_they_asked_for() -> None:
    feed = SignalFeed(KNOWN)
    with feed.listen(["a"]) as first, feed.listen(["a", "b"]) as second:
        assert feed.wanted == {"a", "b"}
        feed.send({"time": 1.0}, {"a": [1.0], "b": [2.0, 3.0]})
        assert messages(first) == [{"status": {"time": 1.0}, "values": {"a": [1.0]}}]
        assert messages(second) == [{"status": {"time": 1.0}, "values": {"a": [1.0], "b": [2.0, 3.0]}}]
    assert feed.wanted == set()


def test_what_is_not_known_is_valid_json() -> None:
    feed = SignalFeed(KNOWN)
    with feed.listen(["a"]) as queue:
        feed.send({}, {"a": [math.nan, math.inf, 1.0]})
        message = queue.get()
    assert message is not None
    assert "NaN" not in message
    assert json.loads(message)["values"]["a"] == [None, None, 1.0]


def test_a_listener_that_is_too_slow_loses_messages_but_not_the_end() -> None:
    feed = SignalFeed(KNOWN)
    with feed.listen([]) as queue:
        for i in range(1000):
            feed.send({"number": i}, {})
        feed.close()
        found = messages(queue)
    assert len(found) <= 100
    assert found[-1] is None


def test_who_comes_after_the_end_is_not_kept_waiting() -> None:
    feed = SignalFeed(KNOWN)
    feed.close()
    with feed.listen([]) as queue:
        assert messages(queue) == [None]
