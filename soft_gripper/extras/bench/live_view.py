"""LiveView: a live session on the page: its scene, tables and plots, and the buttons that zero and record."""

import time
from collections.abc import Callable, Iterable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.framework import OutputPort

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.estimate_scene import EstimateScene
from soft_gripper.diagrams.view.meshcat_view import PERIOD, cut_off, has_failed, hidden_meshcat
from soft_gripper.errors import InputError
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_recorder import BenchRecorder
from soft_gripper.extras.bench.live_tables import finger_table, needed_signals, readings_table
from soft_gripper.extras.bench.session import Session
from soft_gripper.extras.bench.twin import Twin
from soft_gripper.page.panel import Button, Panel
from soft_gripper.page.signal_feed import SignalFeed

ZEROING = 2.0  # s for which `zero` collects readings
_LATENCIES = 1000  # readings over which the latency is shown
_TWIN = "twin."
_OF_TWIN = {  # its signals, by the estimates and measurements that they are compared with
    "strain": "strain",
    "sampled_pressure": "sampled_pressure",
    "external_torque": "true_external_torque",
    "contact_force": "true_contact_force",
    "contact_arc_length": "true_contact_arc_length",
}


class LiveView:
    """Shows a live session while it runs, and obeys the buttons.

    The scene has the fingers as they are estimated and, if there is one, the simulated twin, translucent. The tables
    and plots have what was sent last: while no reading arrives, the last estimates, whose bands widen.
    """

    def __init__(
        self,
        session: Session,
        bench: Bench,
        folder: Path,
        recorded: Sequence[str],
        moving: Sequence[str],
        twin: Twin | None = None,
        clock: Callable[[], float] = time.monotonic,
    ):
        """
        Args:
            session: its `run` is to call `refresh` between turns.
            bench: of the session.
            folder: takes the recordings.
            recorded: signals that these have.
            moving: names of the fingers whose base moves.
            twin: is shown beside; it is advanced by whoever has it.
            clock: real time, s.
        """
        self._session, self._bench, self._twin = session, bench, twin
        self.fingers = list(bench.quantities)
        self.recorder = BenchRecorder(session, bench, recorded, folder)
        self._meshcat = hidden_meshcat()
        self.scene = self._meshcat.web_url()
        self._drawn = EstimateScene(bench.scenario, bench.signals, moving, self._meshcat)
        self._of_twin = {} if twin is None else _compared(twin, bench, self.fingers)
        self.panel = Panel((Button.ZERO, Button.RECORD, Button.STOP))
        self.feed = SignalFeed(self.signals)
        self._clock = clock
        self._began = self._due = clock()
        self._zeroed_at, self._note, self._has_scene, self.is_over = np.inf, "", True, False

    @property
    def signals(self) -> dict[str, OutputPort]:
        """The ports of the signals that can be plotted, by name; those of the twin begin with "twin."."""
        if self._twin is None:
            return dict(self._bench.signals)
        of_twin = self._twin.station.parts.signals
        return {**self._bench.signals, **{name: of_twin[own] for name, own in self._of_twin.items()}}

    @property
    def owners(self) -> list[str]:
        """The fingers, and those of the twin, as they are named in `signals`."""
        return [*self.fingers, *dict.fromkeys(name.rpartition(".")[0] for name in self._of_twin)]

    def refresh(self) -> None:
        """Obeys the buttons, and shows a frame if it is time for one."""
        for button in self.panel.pressed():
            self._react(button)
        now = self._clock()
        if now >= self._zeroed_at:
            self._finish_zeroing()
        if now >= self._due:
            self._due = now + PERIOD
            self._show(now - self._began)

    def _react(self, button: Button) -> None:
        self._note = ""
        if button == Button.STOP:
            self.is_over = True
        elif button == Button.ZERO:
            self._session.zero()
            self._zeroed_at = self._clock() + ZEROING
        elif self.recorder.is_recording:
            self.recorder.end()
        else:
            self.recorder.begin()

    def _finish_zeroing(self) -> None:
        self._zeroed_at = np.inf
        try:
            self._session.zeroed()
            self._note = "zeroed: the sensors now read those of fingers that hang free"
        except InputError as error:
            self._note = f"not zeroed: {error.value} {error.expected}"

    def _show(self, elapsed: float) -> None:
        tabled = needed_signals(self.fingers, self._bench.signals)
        wanted = self.feed.wanted
        values = self._sent({*tabled, *self._drawn.signals, *(wanted - self._of_twin.keys())})
        if self._has_scene:
            self._draw({name: values[name] for name in self._drawn.signals if name in values})
        if self._twin is not None:
            own = self._twin.read([self._of_twin[name] for name in wanted & self._of_twin.keys()])
            values |= {name: own[self._of_twin[name]] for name in wanted & self._of_twin.keys()}
        tables = [finger_table(self.fingers, self._bench.signals, values), readings_table(self._session.counts)]
        self.feed.send({**self._status(elapsed), "tables": tables}, {n: v for n, v in values.items() if n in wanted})

    def _sent(self, names: Iterable[str]) -> dict[str, Array]:
        """Signals as they were sent last, with their wider bands, and those that are not sent; unknown at first."""
        sent = self._session.results
        if self._session.counts.used == 0:
            return {}
        return {name: sent[name] if name in sent else self._bench.read([name])[name] for name in names}

    def _draw(self, values: dict[str, Array]) -> None:
        try:
            self._drawn.show(values)
            if self._twin is not None:
                self._drawn.show_twin(self._twin.positions)
        except RuntimeError:
            if not has_failed(self._meshcat):
                raise
            cut_off(self.scene)  # a new one would take longer than hardware waits
            self._has_scene, self._note = False, "the view failed; estimates and commands go on"

    def _status(self, elapsed: float) -> dict[str, Any]:
        results, is_zeroing = self._session.results, self._session.zeroing
        is_stale = bool(results.get("stale", 1.0))
        waits = "waiting for readings" if self._session.counts.used == 0 else f"stale, {results.get('age', 0.0):.1f} s"
        recent = [*islice(reversed(self._session.latencies), _LATENCIES)]
        middle, most = 1e3 * np.percentile(recent, [50, 99]) if recent else (np.nan, np.nan)
        return {
            "time": elapsed,
            "mode": waits if is_stale else "zeroing" if is_zeroing else "live",
            "alarm": is_stale or self.recorder.is_recording,
            "latency": f"reading to result {middle:.1f} ms, 99 % {most:.1f} ms" if recent else "",
            "zeroing": is_zeroing,
            "recording": self.recorder.is_recording,
            "note": self._note or self.recorder.note,
            "sliders": {},
        }


def _compared(twin: Twin, bench: Bench, fingers: Iterable[str]) -> dict[str, str]:
    """The signals of a twin that are plotted, by their names on the page."""
    pairs = {f"{finger}.{name}": f"{finger}.{own}" for finger in fingers for name, own in _OF_TWIN.items()}
    return {
        _TWIN + name: own for name, own in pairs.items() if name in bench.signals and own in twin.station.parts.signals
    }
