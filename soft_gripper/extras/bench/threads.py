"""Threads for readers of results, users' generators and disks, which may wait, so that the loop never does."""

import os
import select
import time
from collections import deque
from collections.abc import Callable, Iterable
from threading import Condition, Thread
from typing import Any, Generic, TypeVar

ROOM = 100  # maximum of waiting results
_POLL_PERIOD = 0.1  # s between checks whether to go on waiting
LINGER = 1.0  # s for the last results, at the end

_T = TypeVar("_T")
Message = bytes | dict[str, Any]  # encoded, or by name


class Outbox(Generic[_T]):
    """Hands items on, in order, in a separate thread.

    If they are not taken in time, the oldest are dropped and counted, so that a reader gets the newest.
    """

    def __init__(self, take: Callable[[_T], object], until: Callable[[], bool] | None = None, room: int = ROOM):
        """
        Args:
            take: takes an item, and may wait, even for ever.
            until: if given, nothing is dropped: `put` waits for room until this is true.
            room: maximum of waiting items.
        """
        self._take, self._until, self._room = take, until, room
        self._waiting: deque[_T] = deque()
        self._changed = Condition()
        self._is_busy = self._is_closed = False
        self._error: BaseException | None = None
        self.dropped = 0
        Thread(target=self._run, daemon=True).start()

    def put(self, item: _T) -> None:
        """Hands an item on; raises the exception of the last `take`, if that failed."""
        with self._changed:
            while self._until is not None and self._is_full and self._error is None and not self._until():
                self._changed.wait(_POLL_PERIOD)
            if self._error is not None:
                raise self._error
            if self._is_full:
                self._waiting.popleft()
                self.dropped += 1
            self._waiting.append(item)
            self._changed.notify_all()

    def close(self) -> None:
        """Waits until all items are taken, at most `LINGER` s if items may be dropped; drops the rest."""
        end = time.monotonic() + LINGER
        with self._changed:
            while (self._waiting or self._is_busy) and self._error is None:
                is_patient = self._until is not None and not self._until()
                if time.monotonic() > end and not is_patient:
                    break
                self._changed.wait(_POLL_PERIOD)
            self.dropped += len(self._waiting) + self._is_busy
            self._waiting.clear()
            self._is_closed = True
            self._changed.notify_all()
            error, self._error = self._error, None
        if error is not None:
            raise error

    @property
    def _is_full(self) -> bool:
        return len(self._waiting) >= self._room

    def _run(self) -> None:
        while True:
            with self._changed:
                while not self._waiting and not self._is_closed:
                    self._changed.wait()
                if self._is_closed:
                    return
                item, self._is_busy = self._waiting.popleft(), True
            try:
                self._take(item)
            except BaseException as error:  # whatever a user's function may raise
                self._error = error
            with self._changed:
                self._is_busy = False
                self._changed.notify_all()
                if self._error is not None:
                    return


def write_all(descriptor: int, content: bytes) -> None:
    """Writes to a file descriptor that may have no room yet, or only for a part."""
    unwritten_bytes = memoryview(content)
    while unwritten_bytes:
        try:
            unwritten_bytes = unwritten_bytes[os.write(descriptor, unwritten_bytes) :]
        except BlockingIOError:
            poll = select.poll()
            poll.register(descriptor, select.POLLOUT)
            poll.poll(1e3 * LINGER)


class Inbox:
    """Reads the messages of an iterable that may wait, in a separate thread, at a pace."""

    def __init__(self, messages: Iterable[Message], period: float):
        """`period` between messages, s; 0: as fast as they are taken."""
        self._messages, self._period = messages, period
        self._arrived: deque[Message] = deque()
        self._changed = Condition()
        self._is_done = False
        self._error: BaseException | None = None
        Thread(target=self._run, daemon=True).start()

    @property
    def is_over(self) -> bool:
        """Whether the messages have ended."""
        return self._is_done and not self._arrived and self._error is None

    def receive(self, timeout: float) -> list[Message]:
        """Messages that have arrived; after them, raises the exception of the iterable."""
        with self._changed:
            self._changed.wait_for(lambda: self._arrived or self._is_done, timeout)
            if not self._arrived and self._error is not None:
                error, self._error = self._error, None
                raise error
            messages = [*self._arrived]
            self._arrived.clear()
            self._changed.notify_all()
        return messages

    def _run(self) -> None:
        due_time = time.monotonic()
        try:
            for message in self._messages:
                time.sleep(max(0.0, due_time - time.monotonic()))
                due_time += self._period
                with self._changed:
                    self._changed.wait_for(lambda: len(self._arrived) < ROOM)
                    self._arrived.append(message)
                    self._changed.notify_all()
        except BaseException as error:  # whatever a user's generator may raise
            self._error = error
        with self._changed:
            self._is_done = True
            self._changed.notify_all()
