"""LiveView: a bench on the page: its scene, tables and plots, and the buttons that zero and record."""

from collections.abc import Collection, Iterable, Sequence
from contextlib import suppress
from itertools import islice
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.meshcat_view import PERIOD, hidden_meshcat
from soft_gripper.errors import InputError
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import BenchDriver, recorded_signals
from soft_gripper.extras.bench.endpoints import Sink, Source
from soft_gripper.extras.bench.estimate_scene import EstimateScene
from soft_gripper.extras.bench.live_tables import finger_table, needed_signals, readings_table
from soft_gripper.extras.bench.recorder import Recorder, recording_layout
from soft_gripper.extras.hardware.bench_schema import BenchConfig
from soft_gripper.extras.page.panel import Button, Panel
from soft_gripper.extras.page.viewing import cut_off, has_failed
from soft_gripper.scenario.scenario_file import dump_scenario

ZEROING = 2.0  # s for which `zero` collects readings
_SHOWN_LATENCIES = 1000  # readings over which the latency is shown


class LiveView(BenchDriver):
    """Drives a bench that is shown on a page.

    The scene has the fingers as they are estimated. The tables and plots have what was sent last: while no reading
    arrives, the last estimates, whose bands widen.
    """

    def __init__(
        self, bench: Bench, config: BenchConfig, source: Source, sink: Sink, moving: Sequence[str] = (), **others: Any
    ):
        """
        Args:
            bench, config, source, sink, others: as for BenchDriver.
            moving: names of the fingers whose base moves.
        """
        super().__init__(bench, config, source, sink, **others)
        self._layout = recording_layout(bench, recorded_signals(bench, config))
        self.fingers: list[str] = list(bench.quantities)
        self._meshcat = hidden_meshcat()
        self.scene = self._meshcat.web_url()
        self._estimate_scene = EstimateScene(bench.scenario, bench.signals, moving, self._meshcat)
        self.signals = bench.signals
        self.panel = Panel((Button.ZERO, Button.RECORD, Button.STOP))
        self._has_scene = True
        self._began = self._next = self._clock()

    def advance(self) -> bool:
        """Advances the bench; returns whether a frame is due."""
        was_zeroing = self.is_zeroing
        try:
            super().advance()
        except InputError as error:
            if error.field != "--zero":
                raise
            self.note = f"not zeroed: {error.value} {error.expected}"
        else:
            if was_zeroing and not self.is_zeroing:
                self.note = "zeroed: the sensors now read those of fingers that hang free"
        time = self._clock()
        if time < self._next:
            return False
        self._next = time + PERIOD
        return True

    def press(self, _: Button) -> None:
        """Zeroes the sensors."""
        self.zero(ZEROING)

    def record(self, folder: Path) -> Recorder:
        """Begins a recording, which is written while it goes on."""
        folder.mkdir(parents=True)
        self.recorder = Recorder(self._bench, self._layout, folder / "recording.nc")
        Thread(target=self._write_scenario, args=(folder,), daemon=True).start()  # it takes longer than a period
        return self.recorder

    def _write_scenario(self, folder: Path) -> None:
        with suppress(OSError):  # whoever cannot write the recording says so
            (folder / "scenario.yaml").write_text(dump_scenario(self._bench.scenario, folder), encoding="utf-8")

    def recovers(self) -> bool:
        """Whether Meshcat had failed; estimates and commands go on without it."""
        if not self._has_scene or not has_failed(self._meshcat):
            return False
        cut_off(self.scene)  # a new one would take longer than hardware waits
        self._has_scene = False
        self.note = "the view failed; estimates and commands go on"
        return True

    def frame(self, wanted: Collection[str]) -> tuple[dict[str, Any], dict[str, Array]]:
        """Draws the fingers, and returns status, tables and values."""
        table_signals = needed_signals(self.fingers, self._bench.signals)
        values = self._sent_values({*table_signals, *self._estimate_scene.signals, *wanted})
        if self._has_scene:
            self._estimate_scene.show({name: values[name] for name in self._estimate_scene.signals if name in values})
        contents = self.fingers, self._bench.signals, values, self.calibration.disagreeing
        tables = [finger_table(*contents), readings_table(self.counts)]
        return {**self._status(), "tables": tables}, {name: value for name, value in values.items() if name in wanted}

    def _sent_values(self, names: Iterable[str]) -> dict[str, Array]:
        """Values of signals: the last sent ones with wider bands, or else those read; none before the first reading."""
        results = self.results
        if self.counts.used == 0:
            return {}
        return {name: results[name] if name in results else self._bench.read([name])[name] for name in names}

    def _status(self) -> dict[str, Any]:
        results = self.results
        is_zeroing = self.is_zeroing
        is_stale = bool(results.get("stale", 1.0))
        waits = "waiting for readings" if self.counts.used == 0 else f"stale, {results.get('age', 0.0):.1f} s"
        recent_latencies = [*islice(reversed(self.latencies), _SHOWN_LATENCIES)]
        median, p99 = 1e3 * np.percentile(recent_latencies, [50, 99]) if recent_latencies else (np.nan, np.nan)
        latency = f"reading to result {median:.1f} ms, 99 % {p99:.1f} ms" if recent_latencies else ""
        return {
            "time": self._clock() - self._began,
            "mode": waits if is_stale else "zeroing" if is_zeroing else "live",
            "alarm": is_stale or bool(self.calibration.disagreeing),
            "latency": "; ".join(filter(None, (latency, self.command_age_text))),
            "zeroing": is_zeroing,
        }
