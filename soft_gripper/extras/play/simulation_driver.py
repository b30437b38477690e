"""SimulationDriver: a station simulated in real time in place of hardware, commanded and recorded by its user."""

import time
from collections import deque
from collections.abc import Callable, Collection
from contextlib import suppress
from pathlib import Path
from typing import Any

import xarray as xr
from pydrake.geometry import Meshcat, MeshcatAnimation
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import advance, make_simulator
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD, hidden_meshcat, write_animation
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.page.panel import Button
from soft_gripper.extras.page.session import Driver
from soft_gripper.extras.page.viewing import cut_off, has_failed
from soft_gripper.extras.play.control_panel import ControlPanel
from soft_gripper.files.output import atomic_folder
from soft_gripper.scenario.scenario_file import dump_scenario

_PAUSE_PERIOD = 0.1  # s between looks at the buttons while nothing runs
_MAX_VIEWS = 5  # that may fail; Drake 1.51 keeps the memory of each
PATIENCE = 0.5  # s by which the simulation may be late and catch up; a longer delay is kept
WINDOW = 2.0  # s of real time over which the factor is measured


class Pacer:
    """Waits until real time has reached simulated time.

    A slower simulation does not wait, and later catches up by PATIENCE at most.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep):
        """`clock` gives the real time, s, and `sleep` waits for some."""
        self._clock, self._sleep = clock, sleep
        self.played, self._lasted = 0.0, 0.0  # s, simulated and real, between restarts
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begins at a simulated time, s: at the start, and after every pause."""
        self._ahead = self._clock() - simulated
        self._past = deque([(self._clock(), simulated)])

    def keep(self, simulated: float) -> None:
        """Waits until real time has reached `simulated`, s."""
        wait_time = simulated + self._ahead - self._clock()
        if wait_time > 0:
            self._sleep(wait_time)
        elif wait_time < -PATIENCE:
            self._ahead = self._clock() - simulated
        (last_clock, last_simulated), clock = self._past[-1], self._clock()
        self.played, self._lasted = self.played + simulated - last_simulated, self._lasted + clock - last_clock
        self._past.append((clock, simulated))
        while self._past[-1][0] - self._past[0][0] > WINDOW and len(self._past) > 2:
            self._past.popleft()

    @property
    def factor(self) -> float:
        """Recent ratio of simulated to real time; 1 until it is known."""
        (begin, first_simulated), (end, last_simulated) = self._past[0], self._past[-1]
        return (last_simulated - first_simulated) / (end - begin) if end > begin else 1.0

    @property
    def whole_factor(self) -> float:
        """Ratio of simulated to real time since the beginning, without pauses."""
        return self.played / self._lasted if self._lasted else 1.0


class StationRecorder:
    """A recording in progress, written into a folder when it ends.

    It holds `recording.nc`, every signal; `animation.html`, what Meshcat has shown, unless that has failed; and
    `scenario.yaml`.
    """

    def __init__(self, station: Station, meshcat: Meshcat, simulator: Simulator, folder: Path):
        """Begins a recording at time 0; the state of the station does not change."""
        self._station, self._meshcat, self._simulator = station, meshcat, simulator
        self.folder, self.is_open, self.report = folder, True, ""
        meshcat.DeleteRecording()
        meshcat.StartRecording(frames_per_second=1 / PERIOD)
        context = simulator.get_mutable_context()
        station.logs.clear(context)
        # Drake's ContactVisualizer hides new arrows at time 0, so that a recording cannot begin later.
        context.SetTime(0.0)
        simulator.Initialize(InitializeParams(suppress_initialization_events=True))

    def end(self) -> None:
        """Ends the recording and writes its folder."""
        if not self.is_open:
            return
        self.is_open = False
        self._meshcat.StopRecording()
        try:
            with atomic_folder(self.folder) as partial:
                self._write(partial)
        except (InputError, OSError) as error:
            self.report = f"not written: {error}"
        else:
            self.report = f"written: {self.folder}"

    def close(self) -> None:
        """Ends the recording."""
        self.end()

    def _write(self, folder: Path) -> None:
        self._station.recording(self._simulator.get_context()).save(folder / "recording.nc")
        (folder / "scenario.yaml").write_text(dump_scenario(self._station.scenario, folder), encoding="utf-8")
        with suppress(RuntimeError):  # Meshcat has failed
            self._meshcat.PublishRecording()
            write_animation(self._meshcat, folder / "animation.html")
            self._meshcat.SetAnimation(MeshcatAnimation())  # browsers continue to show the simulation


class SimulationDriver(Driver):
    """Drives a station: sliders -> station -> Meshcat and plots.

    Logs are kept only during a recording, so that playing for hours takes no more memory than playing for a minute.
    If Meshcat fails, the station continues in a new one.
    """

    def __init__(self, make: Callable[[Meshcat], Station]):
        """`make` makes the station of an `open_scenario`, shown in a Meshcat."""
        xr.Dataset({"time": [0.0]}).to_netcdf()  # imports the writers of recordings, which takes half a second, now
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
