"""SignalFeed: what happens in the simulation, for those who listen in other threads."""

import json
import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from queue import Full, Queue
from threading import Lock
from typing import Any

_KEPT = 100  # messages that a listener may be behind; more are lost to it


class SignalFeed:
    """Hands messages to every listener, each with the signals that it has asked for."""

    def __init__(self, known: Iterable[str]) -> None:
        """`known` are the names of the signals that can be asked for."""
        self.known = frozenset(known)
        self._listeners: dict[Queue[str | None], frozenset[str]] = {}
        self._lock, self._is_closed = Lock(), False

    @contextmanager
    def listen(self, signals: Collection[str]) -> Iterator[Queue[str | None]]:
        """Messages, JSON, as they come; None says that there are no more.

        Each has `status` as it was sent, and `values` of the signals that are asked for; what is no finite number is
        null.
        """
        queue: Queue[str | None] = Queue(_KEPT)
        with self._lock:
            self._listeners[queue] = frozenset(signals)
            if self._is_closed:
                queue.put(None)
        try:
            yield queue
        finally:
            with self._lock:
                del self._listeners[queue]

    @property
    def wanted(self) -> set[str]:
        """The signals that anybody has asked for."""
        with self._lock:
            return {name for names in self._listeners.values() for name in names}

    def send(self, status: Mapping[str, Any], values: Mapping[str, Collection[float]]) -> None:
        """Tells every listener how things are, and the signals, (size,) each, that it wants."""
        finite = {name: [v if math.isfinite(v) else None for v in map(float, each)] for name, each in values.items()}
        with self._lock:
            for queue, names in self._listeners.items():
                own = {name: value for name, value in finite.items() if name in names}
                _put(queue, json.dumps({"status": status, "values": own}))

    def close(self) -> None:
        """Says that nothing more comes."""
        with self._lock:
            self._is_closed = True
            for queue in self._listeners:
                _put(queue, None)


def _put(queue: "Queue[str | None]", message: str | None) -> None:
    """Adds a message; the end finds room even where messages do not."""
    try:
        queue.put_nowait(message)
    except Full:
        if message is None:
            queue.get_nowait()
            queue.put_nowait(None)
