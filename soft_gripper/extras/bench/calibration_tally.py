"""Whether calibrated fingers stay in the states in which they were calibrated, and agree with them, over a session."""

from collections.abc import Iterator

import numpy as np

from soft_gripper.estimators.calibration_range import DISAGREEMENT, FAR
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.hardware.left_out_regions import NEAREST

_JUDGED = 2.0  # s of readings under a drive that was fitted, after which it is known whether these agree


class _Finger:
    def __init__(self, most: float):
        self.most = most
        self.readings = self.far = self.known = self.near = 0


class CalibrationTally:
    """Counts, for every calibrated finger, the readings that are far from its calibration, and those that agree.

    Readings disagree with the drive if hardly any under a drive that was fitted come near those of a finger that bends
    freely under it: sensors were set anew, or something has touched all the time.
    """

    def __init__(self, bench: Bench):
        states = {name: layout.calibrated for name, layout in bench.layouts.items()}
        self._fingers = {name: _Finger(each.disagreement) for name, each in states.items() if each is not None}
        self._signals = [f"{name}.{own}" for name in self._fingers for own in (FAR, DISAGREEMENT)]
        self._bench, self._least = bench, max(1, round(_JUDGED / bench.period))
        self._said: set[str] = set()

    def note(self) -> Iterator[str]:
        """Takes the last reading; gives a line once it is known that readings and drive of a finger disagree."""
        found = self._bench.read(self._signals)
        for name, finger in self._fingers.items():
            finger.readings += 1
            finger.far += int(found[f"{name}.{FAR}"][0])
            apart = found[f"{name}.{DISAGREEMENT}"][0]
            finger.known += int(np.isfinite(apart))
            finger.near += int(apart <= finger.most)
            if name in self.disagreeing and name not in self._said:
                self._said.add(name)
                how = "zero the sensors while it is free (--zero 2), or calibrate again"
                yield f"WARNING: readings and drive of {name} disagree: if nothing has touched it since, {how}"

    def zeroed(self) -> None:
        """Begins anew: the offsets are others."""
        self._fingers = {name: _Finger(finger.most) for name, finger in self._fingers.items()}
        self._said.clear()

    @property
    def disagreeing(self) -> list[str]:
        """Fingers whose readings and drive disagree."""
        return [
            name
            for name, finger in self._fingers.items()
            if finger.known >= self._least and finger.near < NEAREST * finger.known
        ]

    def lines(self) -> Iterator[str]:
        """A line for every finger that was far from its calibration."""
        for name, finger in self._fingers.items():
            if finger.far:
                share = 100 * finger.far / finger.readings
                yield f"{name}: {share:.0f} % of the readings are far from its calibration, where bands are wider"
