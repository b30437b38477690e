"""Pacer: simulated time is held back to real time."""

import time
from collections import deque
from collections.abc import Callable

PATIENCE = 0.5  # s by which the simulation may be late and catch up; more is given up
WINDOW = 2.0  # s of real time over which the factor is measured


class Pacer:
    """Waits until real time has come as far as simulated time.

    A simulation that is slower than that is not waited for; it does not run faster later to make up for it, beyond
    PATIENCE.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep):
        """`clock` gives the real time, s, and `sleep` waits for some."""
        self._clock, self._sleep = clock, sleep
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begins at a simulated time, s: at first, and after whatever has made time stand still."""
        self._ahead = self._clock() - simulated
        self._past = deque([(self._clock(), simulated)])

    def keep(self, simulated: float) -> None:
        """Waits until real time has come as far as `simulated`, s."""
        early = simulated + self._ahead - self._clock()
        if early > 0:
            self._sleep(early)
        elif early < -PATIENCE:
            self._ahead = self._clock() - simulated
        self._past.append((self._clock(), simulated))
        while self._past[-1][0] - self._past[0][0] > WINDOW and len(self._past) > 2:
            self._past.popleft()

    @property
    def factor(self) -> float:
        """Simulated over real time of late; 1 where nothing is known yet."""
        (began, first), (now, last) = self._past[0], self._past[-1]
        return (last - first) / (now - began) if now > began else 1.0
