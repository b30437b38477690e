"""Recorder: what is played is kept, from when the user says so."""

from contextlib import suppress
from itertools import count
from pathlib import Path

import xarray as xr
from pydrake.geometry import Meshcat, MeshcatAnimation
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD
from soft_gripper.diagrams.view.replay import write_replay
from soft_gripper.files.output import atomic_folder
from soft_gripper.scenario.scenario_file import dump_scenario


class Recorder:
    """Writes recordings of a station into folders 1, 2, 3 ... of `folder`.

    Each holds `recording.nc`, every signal; `replay.html`, what Meshcat has shown; and `scenario.yaml`. Logs are kept
    only while something is recorded, so that playing for hours takes no more memory than playing for a minute.
    """

    def __init__(self, station: Station, meshcat: Meshcat, folder: Path):
        self._station, self._meshcat, self._folder = station, meshcat, folder
        self.is_recording = False
        # Imports what writes a recording; xarray leaves most of that, half a second, until it is used.
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
        """Drops what was logged, unless it is being recorded."""
        if not self.is_recording:
            self._station.logs.clear(context)

    def end(self, context: Context) -> Path | None:
        """Ends the recording, if there is one, and writes it; returns its folder.

        Where Meshcat has failed, there is no replay; the rest needs none.

        Raises:
            InputError: if it cannot be written.
        """
        if not self.is_recording:
            return None
        self.is_recording = False
        self._meshcat.StopRecording()
        folder = next(f for f in (self._folder / str(i) for i in count(1)) if not f.exists())
        with atomic_folder(folder) as partial:
            self._station.recording(context).save(partial / "recording.nc")
            (partial / "scenario.yaml").write_text(dump_scenario(self._station.scenario, partial), encoding="utf-8")
            with suppress(RuntimeError):
                self._write_replay(partial / "replay.html")
        return folder

    def _write_replay(self, file: Path) -> None:
        self._meshcat.PublishRecording()
        write_replay(self._meshcat, file)
        self._meshcat.SetAnimation(MeshcatAnimation())  # browsers go on showing what happens now
