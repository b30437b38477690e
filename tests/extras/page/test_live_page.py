"""The live page: its contents, and the signals that it is sent."""

import json
import math
from typing import Any

import pytest
from pydrake.systems.primitives import PassThrough

from soft_gripper.extras.page.live_page import first_plots, list_plots
from soft_gripper.extras.page.signal_feed import MAX_UNSEEN, SignalFeed
from soft_gripper.signals import describe


def port(size: int = 1, unit="m", **axes):
    return describe(PassThrough(size).get_output_port(), unit, **axes)


def test_fingers_share_a_plot_and_others_do_not() -> None:
    signals = {"left.pressure": port(unit="Pa"), "right.pressure": port(unit="Pa"), "grip.opening": port()}
    plots = list_plots(signals, ["left", "right"])
    assert list(plots) == ["pressure", "grip.opening"]
    assert list(plots["pressure"]["signals"]) == ["left.pressure", "right.pressure"]


def test_units_are_those_that_people_read() -> None:
    plots = list_plots({"a.b": port(unit="rad"), "a.c": port(unit="N")}, [])
    assert (plots["a.b"]["unit"], plots["a.c"]["unit"]) == ("deg", "N")
    assert math.isclose(math.pi * plots["a.b"]["scale"], 180)
    assert plots["a.c"]["scale"] == 1


def test_mixed_units_stay_as_they_are() -> None:
    plots = list_plots({"a.pose": port(3, ("m", "m", "rad"), pose=("x", "z", "heading"))}, [])
    entries = {"a.pose": ["x", "z", "heading"]}
    assert plots["a.pose"] == {"unit": "m, rad", "scale": 1.0, "axes": "pose", "signals": entries}


def test_entries_are_named_by_their_axes_and_a_scalar_is_one_line() -> None:
    plots = list_plots({"a.b": port(4, "m", path=("inner", "outer"), section=(0, 1)), "a.c": port()}, [])
    assert plots["a.b"]["signals"]["a.b"] == ["inner 0", "inner 1", "outer 0", "outer 1"]
    assert plots["a.c"]["signals"]["a.c"] == [""]


def test_the_first_plots_are_there() -> None:
    assert first_plots(["strain", "x", "pressure"]) == ["pressure", "strain"]
    assert first_plots(["pressure", "normal_force", "strain"]) == ["normal_force", "pressure", "strain"]
    assert first_plots(["pressure", "normal_force", "transverse_force"]) == ["transverse_force", "pressure"]
    assert first_plots(["external_torque", "strain", "tension", "theta"]) == ["tension", "external_torque", "theta"]


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
