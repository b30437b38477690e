import json
from typing import Any

import pytest

from soft_gripper.extras.page.signal_feed import MAX_UNSEEN, SignalFeed

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
    assert feed.wanted_signals == {"a", "b"}
    feed.send({"time": 1.0}, {"a": [1.0], "b": [2.0, 3.0]})
    status = {"time": 1.0, "late": 0.0}
    assert first.messages == [{"number": 1, "status": status, "values": {"a": [1.0]}}]
    assert second.messages == [{"number": 1, "status": status, "values": {"a": [1.0], "b": [2.0, 3.0]}}]


def test_who_is_late_is_sent_no_more_until_it_has_seen_what_was_sent() -> None:
    now, quick, slow = [0.0], Heard(), Heard()
    feed = SignalFeed(KNOWN, lambda: now[0])
    feed.listen(quick)
    feed.listen(slow)
    for _ in range(20):
        feed.send({}, {})
        feed.see(quick, quick.messages[-1]["number"])
        now[0] += 0.05
    assert [message["number"] for message in quick.messages] == list(range(1, 21))
    assert {message["status"]["late"] for message in quick.messages} == {0.0}
    assert len(slow.messages) == MAX_UNSEEN
    feed.see(slow, 2)
    feed.send({}, {})
    assert (slow.messages[-1]["number"], slow.messages[-1]["status"]["late"]) == (21, pytest.approx(0.95))
    feed.see(slow, 21)
    feed.see(slow, 10**30)
    feed.see(Heard(), 1)
    feed.listen(slow, ["a"])
    now[0] += 0.1
    feed.send({}, {"a": [1.0]})
    feed.see(slow, 22)
    feed.send({}, {})
    assert slow.messages[-1]["status"]["late"] == 0.0, "it has caught up"
