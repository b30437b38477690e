"""Pacer: keeps simulated time to real time."""

import time
from collections import deque
from collections.abc import Callable

PATIENCE = 0.5  # s by which the simulation may be late and catch up; a longer delay is kept
WINDOW = 2.0  # s of real time over which the factor is measured


class Pacer:
    """Waits until real time has reached simulated time.

    A slower simulation does not wait, and later catches up by PATIENCE at most.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep):
        """`clock` gives the real time, s, and `sleep` waits for some."""
        self._clock, self._sleep = clock, sleep
        self.played, self._lasted = 0.0, 0.0  # s, simulated and real, between restarts
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begins at a simulated time, s: at the start, and after every pause."""
        self._ahead = self._clock() - simulated
        self._past = deque([(self._clock(), simulated)])

    def keep(self, simulated: float) -> None:
        """Waits until real time has reached `simulated`, s."""
        wait_time = simulated + self._ahead - self._clock()
        if wait_time > 0:
            self._sleep(wait_time)
        elif wait_time < -PATIENCE:
            self._ahead = self._clock() - simulated
        (last_clock, last_simulated), time = self._past[-1], self._clock()
        self.played, self._lasted = self.played + simulated - last_simulated, self._lasted + time - last_clock
        self._past.append((time, simulated))
        while self._past[-1][0] - self._past[0][0] > WINDOW and len(self._past) > 2:
            self._past.popleft()

    @property
    def factor(self) -> float:
        """Recent ratio of simulated to real time; 1 until it is known."""
        (begin, first_simulated), (end, last_simulated) = self._past[0], self._past[-1]
        return (last_simulated - first_simulated) / (end - begin) if end > begin else 1.0

    @property
    def whole_factor(self) -> float:
        """Ratio of simulated to real time since the beginning, without pauses."""
        return self.played / self._lasted if self._lasted else 1.0
