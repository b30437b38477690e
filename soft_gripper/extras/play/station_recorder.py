"""StationRecorder: a recording of a part of the run of a station, with an animation."""

from contextlib import suppress
from pathlib import Path

import xarray as xr
from pydrake.geometry import Meshcat, MeshcatAnimation
from pydrake.systems.analysis import InitializeParams, Simulator

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD, write_animation
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_folder
from soft_gripper.scenario.scenario_file import dump_scenario


def import_writers() -> None:
    """Imports the writers of recordings; xarray defers most of that, half a second, until use."""
    xr.Dataset({"time": [0.0]}).to_netcdf()


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
