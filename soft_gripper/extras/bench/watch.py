"""Watches the order and the age of readings, and counts those lost, late, repeated or stale."""

from dataclasses import asdict, dataclass, field

_MAX_GAP = 10**6  # maximum of missing numbers; a number further on is wrong, unless others follow it
_MAX_MISSING = 1000  # maximum of numbers still expected
# Readings in order, all behind the last number or far beyond it: the device counts from there, or that number was wrong
_RESTART_READINGS = 3


@dataclass
class Counts:
    """Counts of the readings of a bench since it began."""

    used: int = 0
    lost: int = 0  # never arrived
    late: int = 0  # arrived after a later one, which had been used already
    repeated: int = 0
    malformed: int = 0  # not as the bench describes, or with an implausible number
    excess: int = 0  # more than the period of the sensors allows, or than could be used in time
    silences: int = 0  # times when the last estimate was older than `stale_after`, so that commands became safe
    restarts: int = 0  # of the device, whose numbers began again, or after a wrong number

    def __str__(self) -> str:
        return ", ".join(f"{count} {name}" for name, count in asdict(self).items())


@dataclass
class Watch:
    """Watches the order of numbered readings."""

    counts: Counts = field(default_factory=Counts)
    _last: int | None = None
    _missing: dict[int, None] = field(default_factory=dict)  # in the order of their numbers
    _skipped: range = range(0)  # numbers in the last gap
    _behind: int = 0  # readings in order that are behind the last
    _next: int = -1  # the number that would follow these

    def accept(self, count: int | None) -> int | None:
        """Number of missing readings before this one; None: this one is too late to be used.

        Args:
            count: number of the reading; None: they are not numbered, and none is ever missing.
        """
        gap = 0
        if count is not None and self._last is not None:
            if self._last < count <= self._last + _MAX_GAP:
                gap = self._note_gap(range(self._last + 1, count))
            elif not self._is_restart(count):
                self._note_late(count)
                return None
            else:
                self._restart(count)
        self._last, self._behind = count, 0
        self.counts.used += 1
        return gap

    def _note_gap(self, gap: range) -> int:
        if gap:
            self._skipped = gap
            self._missing |= dict.fromkeys(gap[:_MAX_MISSING])
            while len(self._missing) > _MAX_MISSING:
                del self._missing[next(iter(self._missing))]
        self.counts.lost += len(gap)
        return len(gap)

    def _is_restart(self, count: int) -> bool:
        self._behind = self._behind + 1 if count == self._next else 1
        self._next = count + 1
        return self._behind >= _RESTART_READINGS

    def _restart(self, count: int) -> None:
        """Restarts the numbering here; readings in a last gap due to a wrong number do not count as lost."""
        self.counts.restarts += 1
        if count in self._skipped:
            self.counts.lost -= self._skipped.stop - count
        self._missing.clear()
        self._skipped = range(0)

    def _note_late(self, count: int) -> None:
        if count in self._missing:
            del self._missing[count]
            self.counts.lost -= 1
            self.counts.late += 1
        elif self._last is not None and count > self._last:
            self.counts.malformed += 1
        else:
            self.counts.repeated += 1
