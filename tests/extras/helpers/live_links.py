"""Readings sent to a live session in real time, over each of its links."""

import os
import socket
import threading
import time
import tty
from contextlib import ExitStack, contextmanager

import numpy as np
import pytest
from waiting import LONG

from soft_gripper.extras.bench.endpoints import Endpoints
from soft_gripper.extras.bench.messages import encoded
from soft_gripper.extras.page.session import Session


@contextmanager
def udp():
    """Yields a source, and what sends it a message, by name."""
    with Endpoints("test") as endpoints, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        source = endpoints.source("udp://:0")
        yield source, lambda message: sender.sendto(encoded(message, "json"), ("127.0.0.1", source.port))


@contextmanager
def pseudo_terminal():
    """As hardware on a serial port."""
    pytest.importorskip("serial")
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    with ExitStack() as stack:
        for descriptor in (ours, theirs):
            stack.callback(os.close, descriptor)
        endpoints = stack.enter_context(Endpoints("test"))
        source = endpoints.source(f"serial://{os.ttyname(theirs)}")
        yield source, lambda message: os.write(ours, encoded(message, "json"))


def by_entry(values):
    """Named numbers; entry i of a vector is called `{name}[i]`."""
    scalars = {name: float(value) for name, value in values.items() if not np.ndim(value)}
    vectors = [
        (f"{name}[{i}]", float(x)) for name, value in values.items() if np.ndim(value) for i, x in enumerate(value)
    ]
    return scalars | dict(vectors)


def feed(driver, send, messages, period):
    """Runs a driver that another thread feeds in real time; its session ends a little after the last has been taken."""
    counts, began, lasts = driver.counts, time.monotonic(), period * len(messages) + 0.3

    def send_all():
        for i, message in enumerate(messages):
            time.sleep(max(0.0, began + period * i - time.monotonic()))
            send(message)

    def is_over():
        waited = time.monotonic() - began
        is_done = counts.used + counts.lost + counts.late >= len(messages)
        return waited > lasts + (0 if is_done else LONG)

    thread = threading.Thread(target=send_all)
    thread.start()
    Session(driver).run(is_over)
    thread.join()
