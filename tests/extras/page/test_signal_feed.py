import json
import math
from typing import Any

from soft_gripper.extras.page.signal_feed import SignalFeed

KNOWN = ("a", "b")


class Heard:
    """A listener, and the messages that it took."""

    def __init__(self) -> None:
        self.messages: list[dict[str, Any]] = []

    def __call__(self, message: str) -> None:
        assert "NaN" not in message
        assert "Infinity" not in message
        self.messages.append(json.loads(message))


def test_everybody_gets_what_they_asked_for() -> None:
    feed, first, second = SignalFeed(KNOWN), Heard(), Heard()
    feed.listen(first, ["a"])
    feed.listen(second, ["a", "b"])
    assert feed.wanted == {"a", "b"}
    feed.send({"time": 1.0}, {"a": [1.0], "b": [2.0, 3.0]})
    assert first.messages == [{"status": {"time": 1.0}, "values": {"a": [1.0]}}]
    assert second.messages == [{"status": {"time": 1.0}, "values": {"a": [1.0], "b": [2.0, 3.0]}}]


def test_a_listener_may_ask_for_others_and_leave() -> None:
    feed, heard = SignalFeed(KNOWN), Heard()
    feed.listen(heard)
    assert feed.wanted == set()
    feed.listen(heard, ["b"])
    assert feed.wanted == {"b"}
    feed.leave(heard)
    feed.leave(heard)
    feed.send({}, {})
    assert (feed.wanted, heard.messages) == (set(), [])


def test_what_is_not_known_is_valid_json() -> None:
    feed, heard = SignalFeed(KNOWN), Heard()
    feed.listen(heard, ["a"])
    feed.send({}, {"a": [math.nan, math.inf, 1.0]})
    assert heard.messages[0]["values"]["a"] == [None, None, 1.0]
