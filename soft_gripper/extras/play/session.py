"""Session: a station that runs in real time, as its user commands, until the user ends it."""

import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import xarray as xr
from pydrake.geometry import Meshcat, MeshcatAnimation
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context

from soft_gripper.diagrams.simulation import advance, make_simulator
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD, cut_off, has_failed, hidden_meshcat, write_animation
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.play.control_panel import ControlPanel
from soft_gripper.files.output import atomic_folder, next_folder
from soft_gripper.page.panel import Button
from soft_gripper.page.signal_feed import SignalFeed
from soft_gripper.scenario.scenario_file import dump_scenario
from soft_gripper.scenario.schema import Scenario


class Recorder:
    """Writes recordings of a station into folders 1, 2, 3 ... of `folder`.

    Each holds `recording.nc`, every signal; `animation.html`, what Meshcat has shown; and `scenario.yaml`. Logs are
    kept only during a recording, so that playing for hours takes no more memory than playing for a minute.
    """

    def __init__(self, station: Station, meshcat: Meshcat, folder: Path):
        self._station, self._meshcat, self._folder = station, meshcat, folder
        self.is_recording = False
        # Imports what writes a recording now; xarray defers most of that, half a second, until it is used.
        xr.Dataset({"time": [0.0]}).to_netcdf()

    def begin(self, simulator: Simulator) -> None:
        """Begins a recording: at time 0, which is now. The state of the station stays as it is."""
        self._meshcat.DeleteRecording()
        self._meshcat.StartRecording(frames_per_second=1 / PERIOD)
        context = simulator.get_mutable_context()
        self._station.logs.clear(context)
        # Drake's ContactVisualizer hides new arrows at time 0, so that a recording cannot begin later.
        context.SetTime(0.0)
        simulator.Initialize(InitializeParams(suppress_initialization_events=True))
        self.is_recording = True

    def forget(self, context: Context) -> None:
        """Clears the logs, unless a recording is in progress."""
        if not self.is_recording:
            self._station.logs.clear(context)

    def end(self, context: Context) -> Path | None:
        """Ends the recording, if there is one, and writes it; returns its folder.

        If Meshcat has failed, there is no animation; the other files are still written.

        Raises:
            InputError: if it cannot be written.
        """
        if not self.is_recording:
            return None
        self.is_recording = False
        self._meshcat.StopRecording()
        folder = next_folder(self._folder)
        with atomic_folder(folder) as partial:
            self._station.recording(context).save(partial / "recording.nc")
            (partial / "scenario.yaml").write_text(dump_scenario(self._station.scenario, partial), encoding="utf-8")
            with suppress(RuntimeError):
                self._write_animation(partial / "animation.html")
        return folder

    def _write_animation(self, file: Path) -> None:
        self._meshcat.PublishRecording()
        write_animation(self._meshcat, file)
        self._meshcat.SetAnimation(MeshcatAnimation())  # browsers continue to show the simulation


PATIENCE = 0.5  # s by which the simulation may be late and catch up; a longer delay is kept
WINDOW = 2.0  # s of real time over which the factor is measured


class Pacer:
    """Waits until real time has reached simulated time.

    A slower simulation does not wait, and later catches up by PATIENCE at most.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep):
        """`clock` gives the real time, s, and `sleep` waits for some."""
        self._clock, self._sleep = clock, sleep
        self.restart(0.0)

    def restart(self, simulated: float) -> None:
        """Begins at a simulated time, s: at the start, and after every pause."""
        self._ahead = self._clock() - simulated
        self._past = deque([(self._clock(), simulated)])

    def keep(self, simulated: float) -> None:
        """Waits until real time has reached `simulated`, s."""
        early = simulated + self._ahead - self._clock()
        if early > 0:
            self._sleep(early)
        elif early < -PATIENCE:
            self._ahead = self._clock() - simulated
        self._past.append((self._clock(), simulated))
        while self._past[-1][0] - self._past[0][0] > WINDOW and len(self._past) > 2:
            self._past.popleft()

    @property
    def factor(self) -> float:
        """Recent ratio of simulated to real time; 1 if not known yet."""
        (began, first), (now, last) = self._past[0], self._past[-1]
        return (last - first) / (now - began) if now > began else 1.0


_IDLE = 0.1  # s between looks at the buttons while nothing runs
_MOST_VIEWS = 5  # that may fail; Drake 1.51 keeps the memory of each


def open_scenario(scenario: Scenario, grip: str | None = None) -> Scenario:
    """This scene without task, set points and pressure steps.

    Args:
        scenario: its models, sensors, estimators, controllers and solver are kept.
        grip: what commands the fingers: the "pressure" of each, or the "opening", held in closed loop; None: the
            opening if the scenario closes that loop.
    """
    closes_loop = scenario.control.set_points is not None or (scenario.task is not None and scenario.task.grips)
    chosen = grip or ("opening" if closes_loop or "opening" in scenario.external else "pressure")
    external = [chosen] if scenario.arm is None else [chosen, "tool"]
    return replace(scenario, task=None, control=replace(scenario.control, set_points=None), external=external)


class Session:
    """Runs a station frame by frame: sliders -> station -> Meshcat and plots.

    A recording in progress is written however the session ends. If Meshcat fails, the station continues in a new one.
    """

    def __init__(self, make: Callable[[Meshcat], Station], folder: Path):
        """`make` makes the station of an `open_scenario`, shown in a Meshcat; `folder` takes its recordings."""
        self._make, self._folder = make, folder
        self.recordings: list[Path] = []
        self._show()
        self.panel, self.feed = ControlPanel(self.station), SignalFeed(self.station.parts.signals)
        self._simulator, self._pacer = make_simulator(self.station), Pacer()
        self._paused, self._note, self._failed = False, "", 0
        self.played, self.lasted = 0.0, 0.0  # s, simulated and real, while it was not paused

    @property
    def factor(self) -> float:
        """Simulated over real time of all that was played."""
        return self.played / self.lasted if self.lasted else 1.0

    def run(self, is_over: Callable[[], bool]) -> None:
        """Plays until the user stops it, or `is_over` after a frame.

        Raises:
            InputError: if Meshcat fails again and again.
        """
        try:
            while not is_over() and Button.STOP not in (pressed := self.panel.pressed()):
                self._frame(pressed)
        finally:
            self._keep_recording()

    def _frame(self, pressed: list[Button]) -> None:
        try:
            for button in pressed:
                self._react(button)
            self._wait() if self._paused else self._play()
        except RuntimeError:
            if not has_failed(self.meshcat):
                raise
            self._show_again()

    def _show(self) -> None:
        self.meshcat = hidden_meshcat()
        self.scene = self.meshcat.web_url()
        self.station = self._make(self.meshcat)
        self._recorder = Recorder(self.station, self.meshcat, self._folder)

    def _show_again(self) -> None:
        """A new Meshcat, and a new station that continues from the state of the previous one."""
        self._keep_recording()
        self._failed += 1
        if self._failed == _MOST_VIEWS:
            raise InputError("play", "Meshcat", f"failed {_MOST_VIEWS} times", "stop the client that sends it junk")
        before = self._simulator.get_context()
        cut_off(self.scene)
        self._show()
        self._simulator = make_simulator(self.station)
        _set_state(self._simulator.get_mutable_context(), before)
        self._simulator.Initialize(InitializeParams(suppress_initialization_events=True))
        self._pacer.restart(before.get_time())
        self._note = f"the view failed and was opened again; {self._note}".removesuffix("; ")

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
        self.panel.reset()
        self._simulator = make_simulator(self.station)
        self._paused, self._note = False, ""

    def _keep_recording(self) -> None:
        try:
            folder = self._recorder.end(self._simulator.get_context())
        except (InputError, OSError) as error:
            self._note = f"not written: {error}"
        else:
            if folder is not None:
                self._note = f"written: {folder}"
                self.recordings.append(folder)

    def _wait(self) -> None:
        self.feed.send(self._status(), {})
        time.sleep(_IDLE)

    def _play(self) -> None:
        began, context = time.monotonic(), self._simulator.get_mutable_context()
        self.panel.apply(self.station, context)
        try:
            advance(self._simulator, self.station, PERIOD * (round(context.get_time() / PERIOD) + 1))
        except SimulationDivergedError as error:
            if has_failed(self.meshcat):
                raise
            self._paused, self._note = True, str(error)
            return
        self._recorder.forget(context)
        self.feed.send(self._status(), self._values())
        self._pacer.keep(context.get_time())
        self.played, self.lasted = self.played + PERIOD, self.lasted + time.monotonic() - began

    def _status(self) -> dict[str, Any]:
        return {
            "time": self._simulator.get_context().get_time(),
            "factor": self._pacer.factor,
            "paused": self._paused,
            "recording": self._recorder.is_recording,
            "note": self._note,
            "sliders": self.panel.values,
        }

    def _values(self) -> Mapping[str, Any]:
        context, diagram = self._simulator.get_context(), self.station.diagram
        return {name: diagram.GetOutputPort(name).Eval(context) for name in self.feed.wanted}


def _set_state(context: Context, of: Context) -> None:
    """Copies the time and the state of another station; not the parameters, which contain the ids of its geometry."""
    context.SetTime(of.get_time())
    context.get_mutable_continuous_state().SetFrom(of.get_continuous_state())
    context.get_mutable_discrete_state().SetFrom(of.get_discrete_state())
    context.get_mutable_state().get_mutable_abstract_state().SetFrom(of.get_state().get_abstract_state())
