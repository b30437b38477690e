"""Estimators that are too slow for the readings: commands are safe when they are due, and the newest readings are used.

Commands and their ages are taken from outside: when a reading was sent, and when results arrived at the sink.
"""

import threading
import time

import numpy as np
import pytest
from live_links import udp
from waiting import LONG

from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import SWITCH_INTERVAL, BenchDriver
from soft_gripper.extras.bench.messages import encoded
from soft_gripper.extras.hardware.bench_schema import bench_from_inputs
from soft_gripper.extras.page.session import Session
from soft_gripper.scenario.scenario_file import load_scenario

PERIOD = 0.01
OVERLOAD = 5 * PERIOD  # s that an estimate takes
SAFE, COMMAND = -100.0, "left_finger.pressure_command"
SECONDS = 1.0
USED = 0.6  # least fraction of the time of the loop in which estimates are computed that are used
SWITCH = 10 * SWITCH_INTERVAL  # s that threads of Python wait for one another between a reading and its result


def compute(seconds):
    """Occupies the interpreter."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        pass


class Oversleep:
    """How late a thread wakes up beside the session: the time that machine and interpreter let one wait."""

    def __enter__(self):
        self.seconds, self._is_over = 0.0, threading.Event()
        self._thread = threading.Thread(target=self._measure)
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._is_over.set()
        self._thread.join()

    def _measure(self):
        while not self._is_over.is_set():
            due = time.monotonic() + 0.002
            time.sleep(0.002)
            self.seconds = max(self.seconds, time.monotonic() - due)


class Overloaded:
    """A session over UDP whose estimates take a time; a device sends readings every period, until it is silent."""

    def __init__(self, stale_after, pass_time):
        self.bench = Bench(
            load_scenario("tip_distance_steps", ["sensor.sections=2", "control.set_points=[0.06, 0.04]"])
        )
        self.config = bench_from_inputs(self.bench.inputs, "test")
        self.config.stale_after, self.config.safe_command, self.config.send = stale_after, SAFE, []
        self.cost, self.costs, self._pass_time = OVERLOAD, [], pass_time
        self._step, self.bench.step = self.bench.step, self._step_slowly
        self.bench.skip = self._skip_slowly
        self.sent, self.results = {}, []  # when, by count; and (when, result)
        self.is_over, self.is_silent = threading.Event(), threading.Event()

    def _step_slowly(self, measured):
        began = time.monotonic()
        self._step(measured)
        self._pass_time(self.cost)
        self.costs.append(time.monotonic() - began)

    def _skip_slowly(self):
        self._step_slowly(self.bench._missing)

    def run(self, until):
        with udp() as (source, send):
            self.driver = BenchDriver(self.bench, self.config, source, self._note)
            device = threading.Thread(target=self._send_readings, args=(send,))
            device.start()
            try:
                Session(self.driver).run(until)
            finally:
                self.is_over.set()
                device.join()

    def _note(self, _, result):
        self.results.append((time.monotonic(), result))

    def _send_readings(self, send):
        began, i = time.monotonic(), 0
        while not self.is_over.wait(max(0.0, began + PERIOD * i - time.monotonic())):
            i += 1
            if not self.is_silent.is_set():
                self.sent[i] = time.monotonic()
                send(self.reading(i))

    def reading(self, count):
        return {"count": float(count), "time": PERIOD * count} | {n: np.zeros(k) for n, k in self.bench.inputs.items()}

    @property
    def ages(self):
        """Of every command that was not safe, s: the age of its reading until another one replaced it."""
        return [
            replaced - self.sent[int(result["count"])]
            for (_, result), (replaced, _) in zip(self.results, self.results[1:], strict=False)
            if result[COMMAND][0] != SAFE
        ]


def for_seconds(seconds):
    end = time.monotonic() + seconds
    return lambda: time.monotonic() > end


@pytest.mark.parametrize(("pass_time", "stale_after"), [(time.sleep, 0.1), (compute, 0.04), (compute, 0.1)])
def test_no_command_is_older_than_promised_and_the_processor_is_used(pass_time, stale_after):
    """An estimate takes five periods; from 0.1 s on some are in time, and are commanded.

    A command is replaced when due, but for the time that threads of the session wait for the processor and for one
    another, as measured by one of them: once until the reading arrives, once until the command is replaced.
    """
    with Oversleep() as late:
        live = Overloaded(stale_after, pass_time)
        live.run(for_seconds(SECONDS))
    counts = live.driver.counts
    assert counts.used >= USED * SECONDS / np.mean(live.costs)
    assert len(live.costs) <= counts.used + 1, "no estimate is made of a reading that is passed over"
    assert counts.used + counts.lost >= max(live.sent) - (2 * max(live.costs) + late.seconds) / PERIOD - 2
    oldest, promised = max([0.0, *live.ages]), stale_after + PERIOD
    waits = SWITCH + 2 * late.seconds
    limit = f"{1e3 * promised:.0f} ms, and {1e3 * waits:.1f} ms for which threads wait"
    print(f"oldest command: {1e3 * oldest:.1f} ms of {limit}; {counts.used} readings used")
    assert oldest < promised + waits
    if stale_after < OVERLOAD:
        assert not live.ages
        assert "none but safe ones" in live.driver.command_age_text


def test_after_overload_it_commands_again():
    live = Overloaded(0.2, time.sleep)
    ends, end = for_seconds(0.5), time.monotonic() + LONG

    def has_recovered():
        live.cost = 0.0 if ends() else 2 * live.config.stale_after
        _, last = live.results[-1]
        return (live.cost == 0 and last[COMMAND][0] != SAFE and last["age"] == 0) or time.monotonic() > end

    live.run(lambda: bool(live.results) and has_recovered())
    assert live.results[-2][1][COMMAND][0] != SAFE
    assert live.results[-1][1][COMMAND][0] == SAFE, "at the end"
    assert live.driver.counts.silences >= 1


def test_a_late_result_replaces_no_safe_command():
    """An estimate ends only once a safe command has replaced the one in force; no other thread could have sent it."""
    live, is_safe_again, waited = Overloaded(0.1, time.sleep), threading.Event(), []
    live.cost = 0.0

    def note(_, result):
        commanded = any(found[COMMAND][0] != SAFE for _, found in live.results)
        live.results.append((time.monotonic(), result))
        if commanded and result[COMMAND][0] == SAFE:
            is_safe_again.set()

    def wait(_):
        if any(found[COMMAND][0] != SAFE for _, found in live.results):
            waited.append(is_safe_again.wait(LONG))
            time.sleep(live.config.stale_after)

    live._note, live._pass_time = note, wait
    live.run(is_safe_again.is_set)
    assert set(waited) == {True}
    commands = [result[COMMAND][0] for _, result in live.results]
    first = next(i for i, command in enumerate(commands) if command != SAFE)
    first_safe = commands.index(SAFE, first)
    assert set(commands[first_safe:]) == {SAFE}
    late = live.results[-2][1]
    assert late["count"] > live.results[first_safe][1]["count"]
    assert (late["stale"], late["age"] > 0.1) == (1.0, True)


def test_losses_are_told_to_the_estimators_while_there_is_time():
    """A second of silence: a hundred samples without readings, of 50 ms each, would end 5 s later."""
    live = Overloaded(0.1, time.sleep)
    live.run(for_seconds(0.2))
    live.costs.clear()
    live.driver._take(encoded(live.reading(1000), "json"), time.monotonic())
    assert 2 <= len(live.costs) <= 3, "at least one of them, and the reading"
    assert live.bench._samples > 100
