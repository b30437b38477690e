"""Summary of a session, in words: contacts and calibration of each finger, and a status line meanwhile."""

import math
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.calibration_range import DISAGREEMENT, FAR
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.endpoints import print_out
from soft_gripper.extras.hardware.fitted_range import NEAREST

_REST_TIME = 0.5  # s without a change of the drive of a finger at rest
_STILL_PRESSURE_FRACTION = 0.01  # of the range of the supply
_STILL_TENSION = 0.5  # N
_CONTACT_READINGS = 3  # readings in a row that make a contact
_TERMINAL_PERIOD = 0.25  # s between lines that overwrite each other
_LOG_PERIOD = 10.0  # s between lines elsewhere
_UNKNOWN_TEXT = "-"


class _FingerTally:
    """Contacts of one finger while its drive rested, and while it changed."""

    def __init__(self, name: str, bench: Bench):
        signals = "transverse_force", "transverse_force_std", "contact_arc_length"
        self._force, self._std, self._place = (f"{name}.{signal}" for signal in signals)
        self._driving = [f"{name}.{kind}" for kind in ("pressure", "tension") if f"{name}.{kind}" in bench.inputs]
        supply = bench.scenario.pressure
        has_pressure = self._driving[:1] == [f"{name}.pressure"]
        self._still = _STILL_PRESSURE_FRACTION * (supply.maximum - supply.minimum) if has_pressure else None
        self._past: deque[Array] = deque(maxlen=max(2, round(_REST_TIME / bench.period)))
        self._touched = 0
        self.name, self.is_known = name, False
        self.contacts = {True: 0, False: 0}  # by whether it rested
        self.largest: dict[bool, tuple[float, float, float]] = {}  # transverse force, its standard deviation and place

    def note(self, measurements: Mapping[str, Array], estimates: Mapping[str, Array]) -> None:
        if self._driving:
            self._past.append(np.concatenate([measurements[name] for name in self._driving]))
        if self._force not in estimates:
            return
        self.is_known, force = True, float(estimates[self._force][0])
        has_contact = math.isfinite(force) and force != 0
        self._touched = self._touched + 1 if has_contact else 0
        if self._touched < _CONTACT_READINGS:
            return
        was_at_rest = self._is_at_rest
        self.contacts[was_at_rest] += self._touched == _CONTACT_READINGS
        if force > self.largest.get(was_at_rest, (0.0,))[0]:
            std, place = (
                float(estimates[name][0]) if name in estimates else math.nan for name in (self._std, self._place)
            )
            self.largest[was_at_rest] = force, std, place

    @property
    def _is_at_rest(self) -> bool:
        limit = _STILL_TENSION if self._still is None else self._still
        return not self._past or bool(np.ptp(np.array(self._past), axis=0).max() <= limit)

    def __str__(self) -> str:
        rest_text, motion_text = (self._contact_text(is_at_rest) for is_at_rest in (True, False))
        lags = " (a finger that moves lags behind its drive)" if self.contacts[False] else ""
        return f"{self.name}: while its drive rested {rest_text}; while that changed {motion_text}{lags}"

    def _contact_text(self, is_at_rest: bool) -> str:
        count = self.contacts[is_at_rest]
        if is_at_rest not in self.largest:
            return "no contact"
        force, std, place = self.largest[is_at_rest]
        return f"{count} contact{'' if count == 1 else 's'}, at most {force:.2f} ± {std:.2f} N, at {1e3 * place:.0f} mm"


class Tally:
    """Contacts of all fingers whose estimates are sent."""

    def __init__(self, bench: Bench):
        self._fingers = [_FingerTally(name, bench) for name in bench.quantities]

    def note(self, measurements: Mapping[str, Array], estimates: Mapping[str, Array]) -> None:
        """Takes the measurements of a reading, by input of the bench, and the estimates that are sent."""
        for finger in self._fingers:
            finger.note(measurements, estimates)

    def lines(self) -> Iterator[str]:
        """Yields a line for each finger with estimated contacts."""
        yield from (str(finger) for finger in self._fingers if finger.is_known)


_JUDGING_TIME = 2.0  # s of readings under a fitted drive before their agreement is judged


class _CalibratedFinger:
    def __init__(self, limit: float):
        self.max_disagreement = limit
        self.readings = self.far = self.known = self.near = 0


class CalibrationTally:
    """Counts the readings of every calibrated finger far from its calibration, and near its free states.

    Readings disagree with the drive if hardly any, under a fitted drive, come near those of a free finger: the sensors
    were remounted, or a contact lasted all the time.
    """

    def __init__(self, bench: Bench):
        states = {name: layout.calibrated for name, layout in bench.layouts.items()}
        self._fingers = {
            name: _CalibratedFinger(state.disagreement) for name, state in states.items() if state is not None
        }
        self._signals = [f"{name}.{signal}" for name in self._fingers for signal in (FAR, DISAGREEMENT)]
        self._bench, self._min_readings = bench, max(1, round(_JUDGING_TIME / bench.period))
        self._warned: set[str] = set()

    def note(self) -> Iterator[str]:
        """Takes the last reading; yields a line once readings and drive of a finger disagree."""
        signals = self._bench.read(self._signals)
        for name, finger in self._fingers.items():
            finger.readings += 1
            finger.far += int(signals[f"{name}.{FAR}"][0])
            disagreement = signals[f"{name}.{DISAGREEMENT}"][0]
            finger.known += int(np.isfinite(disagreement))
            finger.near += int(disagreement <= finger.max_disagreement)
            if name in self.disagreeing and name not in self._warned:
                self._warned.add(name)
                remedy = "zero the sensors while it is free (--zero 2), or calibrate again"
                yield f"WARNING: readings and drive of {name} disagree: if nothing has touched it since, {remedy}"

    def restart(self) -> None:
        """Restarts the counts, after offsets have changed."""
        self._fingers = {name: _CalibratedFinger(finger.max_disagreement) for name, finger in self._fingers.items()}
        self._warned.clear()

    @property
    def disagreeing(self) -> list[str]:
        """Fingers whose readings and drive disagree."""
        return [
            name
            for name, finger in self._fingers.items()
            if finger.known >= self._min_readings and finger.near < NEAREST * finger.known
        ]

    def lines(self) -> Iterator[str]:
        """Yields a line for every finger that was far from its calibration."""
        for name, finger in self._fingers.items():
            if finger.far:
                percent = 100 * finger.far / finger.readings
                yield f"{name}: {percent:.0f} % of the readings are far from its calibration, where bands are wider"


class StatusLine:
    """Sink that prints the state of every finger in one line.

    On a terminal of a width the line is overwritten; elsewhere, None, another follows now and then.
    """

    def __init__(self, bench: Bench, pressure_unit: str, width: int | None):
        self._fingers, self._width = list(bench.quantities), width
        self._parts: dict[str, Callable[..., str]] = {  # by their signals
            "tip_pose": lambda tip: f"tip {1e3 * tip[0]:.1f}, {1e3 * tip[1]:.1f} mm",
            "transverse_force": lambda force: f"{force[0]:.2f} N",
            "transverse_force_std": lambda std: f"± {std[0]:.2f}",
            "pressure_command": lambda u: f"command {' '.join(f'{entry:.4g}' for entry in u)} {pressure_unit}",
            FAR: lambda far: "FAR from its calibration" if far[0] else "",
        }
        self._began, self._due = time.monotonic(), 0.0

    def __call__(self, _: bytes, results: dict[str, Any]) -> None:
        """Prints the line if it is time for one."""
        clock = time.monotonic()
        if clock < self._due:
            return
        self._due = clock + (_TERMINAL_PERIOD if self._width else _LOG_PERIOD)
        line = self.line(results, clock - self._began)
        # The cursor stays at the beginning of the line, so that the next output replaces it.
        text = f"{line}\n" if self._width is None else f"{line[: self._width - 1]:<{self._width - 1}}\r"
        print_out(text.encode(), results)

    def line(self, results: Mapping[str, Any], since: float) -> str:
        """Status line at a time since the session began, s."""
        texts = (f"{finger}: {self._finger_text(results, finger)}" for finger in self._fingers)
        state = "stale" if results["stale"] else "live"
        return f"{since:7.1f} s  {state:<5}  {' | '.join(texts)} | {results['lost']:.0f} lost"

    def _finger_text(self, results: Mapping[str, Any], finger: str) -> str:
        values = {name: results.get(f"{finger}.{name}") for name in self._parts}
        finite = {name: value for name, value in values.items() if value is not None and np.isfinite(value).all()}
        return ", ".join(filter(None, (self._parts[name](value) for name, value in finite.items()))) or _UNKNOWN_TEXT
