"""SimulationDriver: a station simulated in real time in place of hardware, commanded by its user."""

import time
from collections.abc import Callable, Collection
from pathlib import Path
from typing import Any

from pydrake.geometry import Meshcat
from pydrake.systems.analysis import InitializeParams
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import advance, make_simulator
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD, hidden_meshcat
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.page.panel import Button
from soft_gripper.extras.page.session import Driver
from soft_gripper.extras.page.viewing import cut_off, has_failed
from soft_gripper.extras.play.control_panel import ControlPanel
from soft_gripper.extras.play.pacer import Pacer
from soft_gripper.extras.play.station_recorder import StationRecorder, import_writers

_PAUSE_PERIOD = 0.1  # s between looks at the buttons while nothing runs
_MAX_VIEWS = 5  # that may fail; Drake 1.51 keeps the memory of each


class SimulationDriver(Driver):
    """Drives a station: sliders -> station -> Meshcat and plots.

    Logs are kept only during a recording, so that playing for hours takes no more memory than playing for a minute.
    If Meshcat fails, the station continues in a new one.
    """

    def __init__(self, make: Callable[[Meshcat], Station]):
        """`make` makes the station of an `open_scenario`, shown in a Meshcat."""
        import_writers()
        self._make = make
        self._show()
        self.panel: ControlPanel = ControlPanel(self.station)
        self.signals = self.station.parts.signals
        self.fingers = [finger.name for finger in self.station.fingers]
        self._simulator, self.pacer = make_simulator(self.station), Pacer()
        self._is_paused, self._failures = False, 0
        self._recorder: StationRecorder | None = None

    def advance(self) -> bool:
        """Simulates a frame, or waits in a pause."""
        if self._is_paused:
            time.sleep(_PAUSE_PERIOD)
            return True
        context = self._simulator.get_mutable_context()
        if self._recorder is None:
            self.station.logs.clear(context)
        elif not self._recorder.is_open:
            self._recorder = None
            self.pacer.restart(context.get_time())  # it took time to write
        self.panel.apply(self.station, context)
        try:
            advance(self._simulator, self.station, PERIOD * (round(context.get_time() / PERIOD) + 1))
        except SimulationDivergedError as error:
            if has_failed(self.meshcat):
                raise
            self._is_paused, self.note = True, str(error)
            return False
        self.pacer.keep(context.get_time())
        return True

    def frame(self, wanted: Collection[str]) -> tuple[dict[str, Any], dict[str, Array]]:
        """Status and changed values of signals; Meshcat draws as the station runs."""
        context, diagram = self._simulator.get_context(), self.station.diagram
        values = {} if self._is_paused else {name: diagram.GetOutputPort(name).Eval(context) for name in wanted}
        return {"time": context.get_time(), "factor": self.pacer.factor, "paused": self._is_paused}, values

    def press(self, button: Button) -> None:
        """Pauses or resumes the simulation, or resets the station and its sliders."""
        if button == Button.PAUSE:
            self._is_paused = not self._is_paused
        else:
            self._end_recording()
            self.panel.reset()
            self._simulator, self._is_paused = make_simulator(self.station), False
        self.pacer.restart(self._simulator.get_context().get_time())

    def record(self, folder: Path) -> StationRecorder:
        """Begins a recording, with time 0 now."""
        self._recorder = StationRecorder(self.station, self.meshcat, self._simulator, folder)
        self.pacer.restart(0.0)
        return self._recorder

    def recovers(self) -> bool:
        """Whether Meshcat had failed; replaces it, and the station continues from the same state.

        Raises:
            InputError: if it fails again and again.
        """
        if not has_failed(self.meshcat):
            return False
        self._end_recording()
        self._failures += 1
        if self._failures == _MAX_VIEWS:
            raise InputError("play", "Meshcat", f"failed {_MAX_VIEWS} times", "stop the client that sends it junk")
        last_context = self._simulator.get_context()
        cut_off(self.scene)
        self._show()
        self._simulator = make_simulator(self.station)
        _set_state(self._simulator.get_mutable_context(), last_context)
        self._simulator.Initialize(InitializeParams(suppress_initialization_events=True))
        self.pacer.restart(last_context.get_time())
        self.note = "the view failed and was opened again"
        return True

    def close(self) -> None:
        """Ends the recording; a simulation is safe."""
        self._end_recording()
        self.summary = f"Played {self.pacer.played:.1f} s at {self.pacer.whole_factor:.2f} times real time."

    def _show(self) -> None:
        self.meshcat = hidden_meshcat()
        self.scene = self.meshcat.web_url()
        self.station = self._make(self.meshcat)

    def _end_recording(self) -> None:
        if self._recorder is not None:
            self._recorder.end()


def _set_state(context: Context, source: Context) -> None:
    """Copies the time and the state of another station; not the parameters, which contain the ids of its geometry."""
    context.SetTime(source.get_time())
    context.get_mutable_continuous_state().SetFrom(source.get_continuous_state())
    context.get_mutable_discrete_state().SetFrom(source.get_discrete_state())
    context.get_mutable_state().get_mutable_abstract_state().SetFrom(source.get_state().get_abstract_state())
