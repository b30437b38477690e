"""Session: a station that runs in real time, as its user commands, until the user ends it."""

import time
from collections.abc import Mapping
from typing import Any

from pydrake.geometry import Meshcat

from soft_gripper.diagrams.live.control_panel import Button, ControlPanel
from soft_gripper.diagrams.live.interrupts import held_back
from soft_gripper.diagrams.live.pacer import Pacer
from soft_gripper.diagrams.live.recorder import Recorder
from soft_gripper.diagrams.live.signal_feed import SignalFeed
from soft_gripper.diagrams.simulation import advance, make_simulator
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD
from soft_gripper.errors import InputError, SimulationDivergedError

_IDLE = 0.1  # s between looks at the buttons while nothing runs


class Session:
    """Runs a station frame by frame: sliders -> station -> Meshcat and plots.

    A recording that goes on as the session ends, however it does, is written.
    """

    def __init__(self, station: Station, meshcat: Meshcat, feed: SignalFeed, recorder: Recorder):
        """`station` is one of an `open_scenario`, made with this `meshcat`."""
        self._station, self._feed, self._recorder = station, feed, recorder
        self._panel, self._pacer = ControlPanel(meshcat, station), Pacer()
        self.sliders = self._panel.sliders
        self._simulator = make_simulator(station)
        self._paused, self._note = False, ""
        self.played, self.lasted = 0.0, 0.0  # s, simulated and real, while it was not paused

    @property
    def factor(self) -> float:
        """Simulated over real time of all that was played."""
        return self.played / self.lasted if self.lasted else 1.0

    def run(self) -> None:
        """Plays until the user stops it."""
        with held_back() as let_through:
            try:
                while Button.STOP not in (pressed := self._panel.pressed()):
                    for button in pressed:
                        self._react(button)
                    self._wait() if self._paused else self._play()
                    let_through()
            finally:
                self._keep_recording()

    def _react(self, button: Button) -> None:
        if button == Button.PAUSE:
            self._paused, self._note = not self._paused, ""
        elif button == Button.RESET:
            self._reset()
        elif self._recorder.is_recording:
            self._keep_recording()
        else:
            self._recorder.begin(self._simulator)
        self._pacer.restart(self._simulator.get_context().get_time())

    def _reset(self) -> None:
        self._keep_recording()
        self._panel.reset()
        self._simulator = make_simulator(self._station)
        self._paused, self._note = False, ""

    def _keep_recording(self) -> None:
        try:
            folder = self._recorder.end(self._simulator.get_context())
        except (InputError, OSError) as error:
            self._note = f"not written: {error}"
        else:
            self._note = f"written: {folder}" if folder is not None else self._note

    def _wait(self) -> None:
        self._feed.send(self._status(), {})
        time.sleep(_IDLE)

    def _play(self) -> None:
        began, context = time.monotonic(), self._simulator.get_mutable_context()
        self._panel.apply(context)
        try:
            advance(self._simulator, self._station, PERIOD * (round(context.get_time() / PERIOD) + 1))
        except SimulationDivergedError as error:
            self._paused, self._note = True, str(error)
            return
        self._recorder.forget(context)
        self._feed.send(self._status(), self._values())
        self._pacer.keep(context.get_time())
        self.played, self.lasted = self.played + PERIOD, self.lasted + time.monotonic() - began

    def _status(self) -> dict[str, Any]:
        return {
            "time": self._simulator.get_context().get_time(),
            "factor": self._pacer.factor,
            "paused": self._paused,
            "recording": self._recorder.is_recording,
            "note": self._note,
        }

    def _values(self) -> Mapping[str, Any]:
        """Of the signals that are wanted and there: a browser may ask for any."""
        context, diagram = self._simulator.get_context(), self._station.diagram
        known = self._feed.wanted & self._station.parts.signals.keys()
        return {name: diagram.GetOutputPort(name).Eval(context) for name in known}
