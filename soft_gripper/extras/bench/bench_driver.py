"""BenchDriver: the hardware of a scenario in real time: readings in, estimates and commands out."""

import math
import sys
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import repeat
from threading import Condition, Event, Thread
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, described
from soft_gripper.estimators.calibration_range import DISTANCE, FAR
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.extras.bench.bench import SET_POINT, Bench
from soft_gripper.extras.bench.endpoints import MAX_WAITING, Sink, Source
from soft_gripper.extras.bench.messages import MalformedError, count_of, decoded, encoded, select_numbers
from soft_gripper.extras.bench.plausible import FirstPressures, Ranges, check_plausible, plausible_ranges
from soft_gripper.extras.bench.recorder import Recorder
from soft_gripper.extras.bench.tally import CalibrationTally, Tally
from soft_gripper.extras.bench.threads import LINGER, Message
from soft_gripper.extras.bench.watch import Counts, Watch
from soft_gripper.extras.hardware.bench_schema import BenchConfig
from soft_gripper.extras.hardware.measured import factor
from soft_gripper.extras.hardware.recording_schema import LENGTH, AnyInstrument, instruments
from soft_gripper.extras.page.session import Driver

SENT = (  # signals of a finger, and of a grip, that are sent unless the bench names others
    *("tip_pose", "position_std", "external_torque", "contact", "transverse_force", "transverse_force_std"),
    *("contact_force", "contact_force_std"),
    *("contact_arc_length", "contact_arc_length_std", "contact_probability", "contact_force_bounds"),
    *("opening", "torque", "force", "object_width"),
    *(DISTANCE, FAR),
)
COMMANDS = ("pressure_command", "tension_command", "pull_command")
_BAND_SUBJECTS = {  # signals that a band belongs to
    "position_std": ("joint_positions", "tip_pose"),
    "contact_force_std": ("contact_force",),
    "transverse_force_std": ("transverse_force",),
    "contact_arc_length_std": ("contact_arc_length",),
}
_MAX_SKIPPED_TIME = 1.0  # s of lost readings reported to the estimators, whose memory is no longer
_MAX_BUNCH_TIME = 0.5  # s of readings in a bunch; more are in excess
# s that a thread waits while another one computes. Python's 5 ms pass again at every call of the system: four of them
# come between a reading and its result.
SWITCH_INTERVAL = 5e-4
_MAX_WAIT = 0.1  # s that a thread waits before it looks whether the session ends
_CHANGE_WINDOW = 2.0  # s over which the speed of an estimate is measured
_MAX_DEVICE_TIME = 1e20  # of a device's clock, whatever its unit
_MAX_LATENCIES = 100_000  # last readings with a latency


@dataclass
class Reading:
    """Contents of a message."""

    count: int | None
    time: float  # of the device, s; NaN: not given
    values: dict[str, Array]  # by input of the bench


def parse_reading(message: Message, config: BenchConfig, ranges: Ranges, quantities: Mapping[str, str]) -> Reading:
    """Parses and checks the reading in a message.

    Args:
        message: as it arrived.
        config: of the bench.
        ranges: of the inputs of the bench.
        quantities: names of the inputs with the readings of sensors, by finger.

    Raises:
        MalformedError: if it does not match the description of the bench.
    """
    if not isinstance(message, bytes | dict):  # of a user's generator
        raise MalformedError(f"is of type {type(message).__name__}: give a dict, or bytes")
    numbers = message if isinstance(message, dict) else decoded(message, config.format, config.fields)
    values = {}
    for name, finger in config.fingers.items():
        readings = select_numbers(numbers, finger.readings)
        values[quantities[name]] = readings
        driving = {
            "pressure": config.relative(select_numbers(numbers, finger.pressures)),
            "tension": select_numbers(numbers, finger.tensions),
            "X_WB": select_numbers(numbers, finger.base_pose or []),
        }
        driving |= {
            f"measured_{kind}": _instrument_values(numbers, instrument)
            for kind, instrument in instruments(finger).items()
        }
        values |= {f"{name}.{kind}": value for kind, value in driving.items() if f"{name}.{kind}" in ranges}
    if config.opening is not None:
        values[SET_POINT] = select_numbers(numbers, [config.opening])
    measured_names = {*quantities.values(), *(name for name in values if ".measured_" in name)}
    check_plausible(values, ranges, measured_names)
    count = None if config.count is None else count_of(float(select_numbers(numbers, [config.count])[0]))
    device_time = math.nan if config.time is None else float(select_numbers(numbers, [config.time])[0])
    if not abs(device_time) <= _MAX_DEVICE_TIME and not math.isnan(device_time):
        raise MalformedError(f"has the time {device_time}")
    return Reading(count, device_time, values)


def _instrument_values(numbers: Mapping[str, float], config: AnyInstrument) -> Array:
    """Value of an instrument and location of its measurement, in SI units, (2,)."""
    value = factor(config) * select_numbers(numbers, [config.column])
    location = np.array([config.place], dtype=float)
    if config.place_column is not None:
        location = LENGTH[config.place_unit] * select_numbers(numbers, [config.place_column])
    return np.append(value, location)


@dataclass
class Pace:
    """Limits readings to one per period on average, and to a bunch of _MAX_BUNCH_TIME."""

    period: float
    clock: Callable[[], float] = time.monotonic
    _allowed: float = field(init=False)
    _last: float = field(init=False)

    def __post_init__(self) -> None:
        self._last, self._allowed = self.clock(), _MAX_BUNCH_TIME / self.period

    def allows(self) -> bool:
        """Whether another reading may be used now."""
        time = self.clock()
        # A device whose clock is a little faster than this one's is no flood.
        self._allowed += 1.1 * (time - self._last) / self.period
        self._allowed = min(self._allowed, _MAX_BUNCH_TIME / self.period)
        self._last = time
        if self._allowed < 1:
            return False
        self._allowed -= 1
        return True


class BenchDriver(Driver):
    """Feeds readings to a bench as they arrive, and sends its results.

    A result has `count` and `time` of its reading, `age`, `stale`, `lost` (readings so far), the signals that are sent,
    and commands; always the same numbers, NaN if unknown. While a result is overdue, others follow every
    period all the same: the last estimates, with bands that widen by the most that the estimates changed of late over
    as long a time. From `stale_after` on they are `stale`, and commands are safe. `age` is the time since the reading
    arrived, s; 0 where its estimates are sent for the first time, unless they are stale by then.

    In a session, a thread of its own notes when readings arrive, and sends what is overdue: it waits for no estimator.
    Once estimates would be stale before they are sent, the newest reading alone is used; the others are passed over.
    """

    def __init__(
        self,
        bench: Bench,
        config: BenchConfig,
        source: Source,
        sink: Sink,
        is_live: bool = True,
        clock: Callable[[], float] = time.monotonic,
        say: Callable[[str], object] = lambda _: None,
    ):
        """`is_live`: readings come at the pace of `clock`, s; otherwise they are used as fast as possible.

        `say` takes what is odd about the first readings, a line each.
        """
        self._bench, self._config, self._source, self._sink = bench, config, source, sink
        self._clock = clock
        self._ranges = plausible_ranges(bench, config)
        self._watch = Watch()
        self._pace = Pace(bench.period, clock) if is_live else None
        self.sent = sent_signals(bench, config)
        self._commands = [name for name in bench.signals if name.rpartition(".")[2] in COMMANDS]
        self._changes = _RecentChanges(bench, self.sent)
        self._offsets: dict[str, Array] = {}
        self._zeroing: list[dict[str, Array]] | None = None
        self._zeroed_at = math.inf
        self._last: Reading | None = None
        self._arrived = clock()
        self._due = self._arrived + 1.5 * bench.period
        self._is_silent = False
        self._restarts_control = False  # before the next estimate, as safe commands have been in force
        # Of both threads, under this lock, as is all that is sent:
        self._changed = Condition()
        self._waiting: deque[tuple[Message, float]] = deque()  # messages, and when they arrived
        self._source_is_over = False
        self._error: BaseException | None = None
        self._listener: Thread | None = None
        self._closes = Event()
        self._switch_interval = sys.getswitchinterval()
        self._passed_over = 0  # readings since the last that was used
        self._cost = 0.0  # s, of the last estimate
        self._command: dict[str, Array] = {}  # of the last reading
        self._in_force: float | None = None  # when the reading of the command in force arrived; None: it is safe
        self.max_command_age = 0.0  # s, the greatest age of a reading while a command based on it was in force
        self.recorder: Recorder | None = None  # takes every sample
        self.tally = Tally(bench)
        self.calibration = CalibrationTally(bench)
        self._first = FirstPressures(bench.period, config)
        self._say = say
        self.malformed = ""  # fault of the first malformed message
        self.latencies: deque[float] = deque(maxlen=_MAX_LATENCIES)  # s, from a message to its result
        self.efforts: deque[float] = deque(maxlen=_MAX_LATENCIES)  # s, processor time of the same
        no_results = {name: np.full(bench.signals[name].size(), np.nan) for name in self.sent}
        self._estimates: dict[str, Array] = no_results  # of the last reading
        self.results: dict[str, Any] = no_results  # the last that were sent; SI units

    @property
    def counts(self) -> Counts:
        """Counts of readings so far, by outcome."""
        return self._watch.counts

    @property
    def command_age_text(self) -> str:
        """The greatest age of the commands so far, in words; empty where nothing is commanded at a pace."""
        if self._pace is None or not self._commands:
            return ""
        age_limit_text = f"{1e3 * self.max_command_age:.0f} ms" if self.max_command_age else "none but safe ones"
        return f"oldest command in force: {age_limit_text}"

    @property
    def is_zeroing(self) -> bool:
        """Whether readings are being collected to zero the sensors."""
        return self._zeroing is not None

    def zero(self, seconds: float) -> None:
        """Collects readings for some seconds, with safe commands; fingers are free and at rest."""
        self._zeroing, self._zeroed_at = [], self._clock() + seconds

    def end_zeroing(self) -> None:
        """Zeroes the sensors: the mean of the collected readings becomes the reading of free fingers.

        Raises:
            InputError: if nothing was collected.
        """
        samples, self._zeroing, self._zeroed_at = self._zeroing, None, math.inf
        self._bench.restart_control()
        if not samples:
            raise InputError(
                "live", "--zero", "no reading", "arrived; the source must send while the sensors are zeroed"
            )
        for name in samples[0]:
            offsets = np.array([sample[name] for sample in samples])
            counts = np.isfinite(offsets).sum(axis=0)
            # A sensor that was never read keeps its offset.
            self._offsets[name] = self._offsets.get(name, 0.0) + np.nansum(offsets, axis=0) / np.maximum(counts, 1)
        self._bench.restart_estimation()
        self.calibration.restart()

    @property
    def is_over(self) -> bool:
        """Whether no further reading will arrive."""
        return self._source_is_over and not self._waiting and self._error is None

    def begin(self) -> None:
        """Starts a thread that receives readings and sends overdue results."""
        self._closes.clear()
        if self._pace is not None:
            sys.setswitchinterval(min(SWITCH_INTERVAL, self._switch_interval))
            self._listener = Thread(target=self._listen, daemon=True)
            self._listener.start()

    def close(self) -> None:
        """Sends the last results again, with safe commands."""
        with self._changed:
            self._closes.set()
            self._send_safe()
        if self._listener is not None:
            self._listener.join(LINGER)
            sys.setswitchinterval(self._switch_interval)

    def advance(self) -> bool:
        """Waits for readings, at most until the next result is due, and uses them.

        Raises:
            InputError: if the estimators fail, an own source or sink does, or no reading came to zero the sensors.
        """
        if self._listener is None:
            self._receive(self._source.receive)
        with self._changed:
            if self._listener is not None:
                self._changed.wait_for(
                    lambda: self._waiting or self._source_is_over or self._error is not None,
                    min(1.5 * self._bench.period, _MAX_WAIT),
                )
            waiting = [*self._waiting]
            self._waiting.clear()
            if not waiting and self._error is not None:
                error, self._error = self._error, None
                raise error
        for i, (message, arrival) in enumerate(waiting, 1):
            # Both this reading, and then the newest, are to be estimated in time.
            is_late = self._would_be_stale(arrival, 1) or self._would_be_stale(waiting[-1][1], 2)
            if self._pace is not None and i < len(waiting) and is_late:
                self._take_newest(waiting[i - 1 :])
                break
            self._take(message, arrival)
        if self._clock() >= self._zeroed_at:
            self.end_zeroing()
        return False

    def _listen(self) -> None:
        def wait(seconds: float) -> list[Message]:
            self._closes.wait(seconds)
            return []

        while not self._closes.is_set():
            try:
                self._receive(wait if self._source_is_over or self._error is not None else self._source.receive)
            except BaseException as error:  # whatever a user's source or sink may raise: `advance` raises it
                with self._changed:
                    self._error = error
                    self._changed.notify_all()

    def _receive(self, receive: Callable[[float], list[Message]]) -> None:
        """Waits for messages, at most until a result is due, and then sends the result."""
        messages = receive(min(max(0.0, self._due - self._clock()), _MAX_WAIT))
        arrival = self._clock()
        with self._changed:
            self._waiting += zip(messages, repeat(arrival))
            while len(self._waiting) > MAX_WAITING:
                self._waiting.popleft()
                self.counts.excess += 1
            self._source_is_over = self._source.is_over
            self._changed.notify_all()
            if self._pace is not None and self._clock() >= self._due and not self._closes.is_set():
                self._send_known(is_new=False)

    def _would_be_stale(self, arrival: float, estimates: int) -> bool:
        """Whether a reading would be stale after a number of estimates that cost as much as the last."""
        return self._clock() - arrival + estimates * self._cost >= self._config.stale_after

    def _take_newest(self, waiting: list[tuple[Message, float]]) -> None:
        """Uses the newest valid message, and passes over those before."""
        while waiting:
            message, arrival = waiting.pop()
            self._passed_over += len(waiting)
            if self._take(message, arrival):
                self.counts.excess += len(waiting)
                return
            self._passed_over -= len(waiting)

    def _take(self, message: Message, arrival: float) -> bool:
        """Uses the reading in a message, unless it comes too late; returns whether the message holds one."""
        begin, effort = self._clock(), time.thread_time()
        try:
            reading = parse_reading(message, self._config, self._ranges, self._bench.quantities)
        except MalformedError as error:
            self.counts.malformed += 1
            self.malformed = self.malformed or str(error)
            return False
        if self._pace is not None and not self._pace.allows():
            self.counts.excess += 1
            return True
        missing = self._watch.accept(reading.count)
        if missing is None:
            return True  # a newer estimate has been sent already
        estimates = self._estimate(reading, missing, arrival)
        for line in (*self._first.note(reading.values), *(() if self.is_zeroing else self.calibration.note())):
            self._say(line)
        command = self._bench.read(self._commands)
        with self._changed:
            self._last = reading
            self._arrived = arrival
            self._estimates = estimates
            self._command = {n: np.where(np.isfinite(u), u, self._config.safe_command) for n, u in command.items()}
            self._send_known(is_new=True)
            self._changes.note()
        self.tally.note(reading.values, estimates)
        end = self._clock()
        self._cost = end - begin
        self.latencies.append(end - arrival)
        self.efforts.append(time.thread_time() - effort)
        return True

    def _estimate(self, reading: Reading, missing: int, arrival: float) -> dict[str, Array]:
        """Estimates from a reading; `missing` readings before it did not arrive."""
        try:
            self._let_pass(missing, arrival)
            if self._restarts_control:
                self._restarts_control = False
                self._bench.restart_control()  # safe commands have moved the fingers
            self._use(reading)
            self._record(math.nan if reading.count is None else reading.count, reading.time)
            return self._bench.read(self.sent)
        except (InputError, MemoryError):
            raise
        except Exception as error:  # numpy's and Drake's, and those of a user's estimator
            raise InputError("live", "reading", reading.count, f"the estimators failed: {described(error)}") from error

    def _let_pass(self, missing: int, arrival: float) -> None:
        """Lets the time of missing readings pass.

        The estimators process lost readings while there is time, those passed over never: it costs as much as an
        estimate.
        """
        passed_over, self._passed_over = self._passed_over, 0
        lost_count = min(max(0, missing - passed_over), round(_MAX_SKIPPED_TIME / self._bench.period))
        while lost_count and not (self._pace and self._clock() - arrival > 0.5 * self._config.stale_after):
            self._bench.skip()
            self._record(math.nan, math.nan)
            lost_count -= 1
        self._bench.pass_over(lost_count + passed_over)
        if self.recorder is not None and self.recorder.is_open:
            self.recorder.pass_over(lost_count + passed_over)

    def _record(self, count: float, device_time: float) -> None:
        if self.recorder is not None and self.recorder.is_open:
            self.recorder.take(count, device_time)

    def _use(self, reading: Reading) -> None:
        values = {name: value - self._offsets.get(name, 0.0) for name, value in reading.values.items()}
        self._bench.step(values)
        if self._zeroing is not None:
            expected = self._bench.free_readings()
            self._zeroing.append({name: values[name] - free_reading for name, free_reading in expected.items()})

    def _header(self, age: float, is_stale: bool) -> dict[str, Any]:
        count = math.nan if self._last is None or self._last.count is None else float(self._last.count)
        device_time = math.nan if self._last is None else self._last.time
        return {
            "count": count,
            "time": device_time,
            "age": age,
            "stale": float(is_stale),
            "lost": float(self.counts.lost),
        }

    def _send_known(self, is_new: bool) -> None:
        """Sends the last estimates, with their commands unless these are too old; under the lock."""
        time = self._clock()
        age = time - self._arrived if self._pace is not None else 0.0
        due_time = max(time + self._bench.period, self._arrived + 1.5 * self._bench.period * is_new)
        stale_at = self._arrived + self._config.stale_after
        self._due = stale_at if time < stale_at < due_time else due_time
        if self._last is None:
            self._send_safe()
            return
        # The clock may reach `stale_at` with an age that rounds to less.
        is_stale = self._pace is not None and time >= stale_at
        if is_stale and not self._is_silent:
            self.counts.silences += 1
        self._is_silent = is_stale
        self._restarts_control |= is_stale
        is_fresh = is_new and not is_stale
        estimates = self._estimates if is_fresh else self._changes.widened(self._estimates, age)
        header = self._header(0.0 if is_fresh else age, is_stale)
        if is_stale or self.is_zeroing:
            self._send(header | estimates | self._safe_commands())
        else:
            self._send(header | estimates | self._command, self._arrived)

    def _send_safe(self) -> None:
        """Sends the last results again, with safe commands; under the lock."""
        last_results = {name: self.results[name] for name in self.sent}
        self._send(self._header(self._clock() - self._arrived, True) | last_results | self._safe_commands())

    def _safe_commands(self) -> dict[str, Array]:
        """Commands without estimates, from `safe_command`."""
        return {name: np.full(self._bench.signals[name].size(), self._config.safe_command) for name in self._commands}

    def _send(self, results: dict[str, Any], commanded: float | None = None) -> None:
        """Sends results; `commanded`: when the reading of their commands arrived, None if these are safe."""
        self.results = results
        factor = self._config.pressure_factor
        sent_values = {k: value / factor if k.endswith(".pressure_command") else value for k, value in results.items()}
        self._sink(encoded(sent_values, self._config.sink_format or self._config.format), sent_values)
        if self._in_force is not None:
            self.max_command_age = max(self.max_command_age, self._clock() - self._in_force)
        self._in_force = commanded if self._commands else None


def sent_signals(bench: Bench, config: BenchConfig) -> list[str]:
    """Signals of a bench in its results, commands excluded."""
    names = _default_signals(bench) if config.send is None else config.send
    return [name for name in names if name.rpartition(".")[2] not in COMMANDS]


def recorded_signals(bench: Bench, config: BenchConfig) -> list[str]:
    """Signals of a bench that are recorded: measurements, results, commands, and the shape."""
    default_names = [*_default_signals(bench), *(name for name in bench.signals if name.endswith(f".{ANGLES}"))]
    commands = [name for name in bench.signals if name.rpartition(".")[2] in COMMANDS]
    result_names = default_names if config.record is None else config.record
    return [*dict.fromkeys([*bench.measured, *sent_signals(bench, config), *result_names, *commands])]


def _default_signals(bench: Bench) -> list[str]:
    return [name for name in bench.signals if name.rpartition(".")[2] in SENT]


class _RecentChanges:
    """Largest recent changes of estimates, which widen their bands while no reading arrives."""

    def __init__(self, bench: Bench, sent_names: Sequence[str]):
        self._bench = bench
        self._subjects: dict[str, list[str]] = {}  # by band
        for band in sent_names:
            finger, _, name = band.rpartition(".")
            subjects = [f"{finger}.{quantity}" for quantity in _BAND_SUBJECTS.get(name, ())]
            if subjects and set(subjects) <= bench.signals.keys():
                self._subjects[band] = subjects
        self._past: deque[dict[str, Array]] = deque(maxlen=round(_CHANGE_WINDOW / bench.period))

    def note(self) -> None:
        """Remembers the estimates of the last sample."""
        self._past.append({band: _points(self._bench.read(names)) for band, names in self._subjects.items()})

    def widened(self, results: Mapping[str, Array], age: float) -> dict[str, Array]:
        """Copy of results with bands widened for an age, s."""
        widened_results = dict(results)
        if len(self._past) < 2:
            return widened_results
        past_samples = min(max(1, round(age / self._bench.period)), len(self._past) // 2)
        age_factor = max(1.0, age / (past_samples * self._bench.period))
        for band in self._subjects.keys() & results.keys():
            past_points = np.array([points[band] for points in self._past])
            changes = np.nan_to_num(past_points[past_samples:] - past_points[:-past_samples])
            widened_results[band] = np.hypot(results[band], age_factor * np.linalg.norm(changes, axis=-1).max(axis=0))
        return widened_results


def _points(subjects: Mapping[str, Array]) -> Array:
    """Scalars, (1, 1), or points of joints and tip, (N + 1, 2)."""
    first, *tip = subjects.values()
    return np.concatenate([first.reshape(-1, 2), tip[0][None, :2]]) if tip else first.reshape(-1, 1).copy()
