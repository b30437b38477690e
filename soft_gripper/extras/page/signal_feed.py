"""SignalFeed: messages for all viewers of a page."""

import json
import math
import time
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from threading import Lock
from typing import Any

Listener = Callable[[str], None]  # takes a message, JSON, and does not wait
MAX_UNSEEN = 4  # messages on their way to a listener: enough for 20 a second over a line with a delay of 0.2 s
_RETRY_PERIOD = 2.0  # s until another follows, since messages may be lost


@dataclass
class _ListenerState:
    """A listener's signals, and its unseen messages."""

    signals: frozenset[str]
    unseen: deque[tuple[int, float]] = field(default_factory=lambda: deque(maxlen=MAX_UNSEEN))  # numbers, times in s
    delay: float = 0.0  # s, of what it saw last

    def is_due(self, time: float) -> bool:
        """Whether the listener keeps up, or has been sent nothing for long."""
        return len(self.unseen) < MAX_UNSEEN or time - self.unseen[-1][1] >= _RETRY_PERIOD

    def late(self, time: float) -> float:
        """Delay of the listener, s."""
        return max(self.delay, time - self.unseen[0][1] if self.unseen else 0.0)

    def see(self, number: int, time: float) -> None:
        while self.unseen and self.unseen[0][0] <= number:
            self.delay = time - self.unseen.popleft()[1]


class SignalFeed:
    """Passes messages to every listener, each with the signals that it requested.

    A listener confirms what it has seen. While several messages wait for it, it is sent no others: the next is new.
    """

    def __init__(self, signals: Iterable[str], clock: Callable[[], float] = time.monotonic) -> None:
        """`signals` are the names of the signals that can be requested; `clock` gives the time, s."""
        self.signals = frozenset(signals)
        self._readers: dict[Listener, _ListenerState] = {}
        self._lock, self._clock, self._number = Lock(), clock, 0

    def listen(self, listener: Listener, signals: Collection[str] = ()) -> None:
        """Passes every message from now on to `listener`, with the requested signals.

        Each has its `number`, `status` as it was sent with `late`, how far the listener is behind, s, and `values` of
        the signals requested; what is not a finite number is null.
        """
        with self._lock:
            self._readers.setdefault(listener, _ListenerState(frozenset())).signals = frozenset(signals)

    def see(self, listener: Listener, number: int) -> None:
        """Confirms that a listener has seen the messages up to a number."""
        with self._lock:
            if listener in self._readers:
                self._readers[listener].see(number, self._clock())

    def leave(self, listener: Listener) -> None:
        """Removes a listener."""
        with self._lock:
            self._readers.pop(listener, None)

    @property
    def wanted_signals(self) -> set[str]:
        """The signals requested by any listener."""
        with self._lock:
            return {name for reader in self._readers.values() for name in reader.signals}

    def send(self, status: Mapping[str, Any], values: Mapping[str, Collection[float]]) -> None:
        """Sends every listener that keeps up the status, and the signals, (size,) each, that it wants."""
        finite_values = {
            name: [x if math.isfinite(x) else None for x in map(float, entries)] for name, entries in values.items()
        }
        with self._lock:
            self._number, time = self._number + 1, self._clock()
            for listener, reader in self._readers.items():
                if not reader.is_due(time):
                    continue
                delay = reader.late(time)
                reader.unseen.append((self._number, time))
                listener_values = {name: value for name, value in finite_values.items() if name in reader.signals}
                message = {"number": self._number, "status": {**status, "late": delay}, "values": listener_values}
                listener(json.dumps(message))
