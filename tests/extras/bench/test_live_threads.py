"""What may wait holds nothing up: results are dropped and counted, and errors arrive where they can be told."""

import threading
import time

import pytest
from waiting import LONG

from soft_gripper.extras.bench import threads
from soft_gripper.extras.bench.threads import ROOM, Inbox, Outbox

AT_ONCE = 3.0  # s, on a busy machine


def test_what_nobody_takes_is_dropped_but_the_newest(monkeypatch):
    monkeypatch.setattr(threads, "LINGER", 0.1)
    goes_on, taken = threading.Event(), []
    outbox = Outbox(lambda item: (goes_on.wait(), taken.append(item)))
    began = time.monotonic()
    for i in range(1000):
        outbox.put(i)
    assert time.monotonic() - began < AT_ONCE
    assert outbox.dropped >= 1000 - ROOM - 1
    goes_on.set()
    outbox.close()
    assert taken[-1] == 999
    assert outbox.dropped + len(taken) == 1000


def test_a_signal_ends_waiting_for_room(monkeypatch):
    monkeypatch.setattr(threads, "LINGER", 0.1)
    is_over = threading.Event()
    outbox = Outbox(lambda _: threading.Event().wait(), is_over.is_set)
    threading.Timer(0.2, is_over.set).start()
    for i in range(2 * ROOM):
        outbox.put(i)
    outbox.close()
    assert outbox.dropped == 2 * ROOM


def test_a_generator_that_waits_holds_nothing_up():
    goes_on = threading.Event()

    def messages():
        yield {"a": 1.0}
        goes_on.wait()
        yield {"a": 2.0}
        raise ZeroDivisionError

    inbox = Inbox(messages(), 0.0)
    assert inbox.receive(LONG) == [{"a": 1.0}]
    assert inbox.receive(0.01) == []
    assert not inbox.is_over
    goes_on.set()
    assert inbox.receive(LONG) == [{"a": 2.0}]
    with pytest.raises(ZeroDivisionError):
        inbox.receive(LONG)
    assert inbox.is_over
