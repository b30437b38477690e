"""Watches the order and the age of readings: what is lost, late, repeated or stale is counted, never passed over."""

from dataclasses import asdict, dataclass, field

_MOST_MISSING = 1000  # numbers that are still waited for
_RESTART = 1000  # numbers that a device falls back by when it restarts


@dataclass
class Counts:
    """What has happened to the readings of a bench since it began."""

    used: int = 0
    lost: int = 0  # never arrived
    late: int = 0  # arrived after a later one, which had been used already
    repeated: int = 0
    malformed: int = 0  # not what the bench describes
    excess: int = 0  # more than the period of the sensors allows, or than could be used in time
    silences: int = 0  # times when no reading arrived for `stale_after`
    restarts: int = 0  # of the device: its numbers began again

    def __str__(self) -> str:
        return ", ".join(f"{number} {name}" for name, number in asdict(self).items())


@dataclass
class Watch:
    """The order of numbered readings."""

    counts: Counts = field(default_factory=Counts)
    _last: int | None = None
    _missing: dict[int, None] = field(default_factory=dict)  # in the order of their numbers

    def accept(self, count: int | None) -> int | None:
        """How many readings before this one are missing; None: it is too late to be used.

        Args:
            count: number of the reading; None: they are not numbered, and none is ever missing.
        """
        if count is None or self._last is None or self._last - count >= _RESTART:
            self.counts.restarts += count is not None and self._last is not None
            self._missing.clear()
            gap = 0
        elif count <= self._last:
            self._note_late(count)
            return None
        else:
            gap = count - self._last - 1
            first = max(self._last + 1, count - _MOST_MISSING)
            self._missing |= dict.fromkeys(range(first, count))
            while len(self._missing) > _MOST_MISSING:
                del self._missing[next(iter(self._missing))]
        self._last = count
        self.counts.lost += gap
        self.counts.used += 1
        return gap

    def _note_late(self, count: int) -> None:
        if count in self._missing:
            del self._missing[count]
            self.counts.lost -= 1
            self.counts.late += 1
        else:
            self.counts.repeated += 1
