"""SignalFeed: messages for all who look at a page."""

import json
import math
from collections.abc import Callable, Collection, Iterable, Mapping
from threading import Lock
from typing import Any

Listener = Callable[[str], None]  # takes a message, JSON, and does not wait


class SignalFeed:
    """Passes messages to every listener, each with the signals that it requested."""

    def __init__(self, known: Iterable[str]) -> None:
        """`known` are the names of the signals that can be requested."""
        self.known = frozenset(known)
        self._listeners: dict[Listener, frozenset[str]] = {}
        self._lock = Lock()

    def listen(self, listener: Listener, signals: Collection[str] = ()) -> None:
        """From now on `listener` takes every message, with these signals.

        Each has `status` as it was sent, and `values` of the signals requested; what is not a finite number
        is null.
        """
        with self._lock:
            self._listeners[listener] = frozenset(signals)

    def leave(self, listener: Listener) -> None:
        """Ends what `listen` began."""
        with self._lock:
            self._listeners.pop(listener, None)

    @property
    def wanted(self) -> set[str]:
        """The signals requested by any listener."""
        with self._lock:
            return {name for names in self._listeners.values() for name in names}

    def send(self, status: Mapping[str, Any], values: Mapping[str, Collection[float]]) -> None:
        """Sends every listener the status, and the signals, (size,) each, that it wants."""
        finite = {name: [v if math.isfinite(v) else None for v in map(float, each)] for name, each in values.items()}
        with self._lock:
            for listener, names in self._listeners.items():
                own = {name: value for name, value in finite.items() if name in names}
                listener(json.dumps({"status": status, "values": own}))
