"""Recorder: what is played is kept, from when the user says so."""

from itertools import count
from pathlib import Path

from pydrake.geometry import Meshcat, MeshcatAnimation
from pydrake.systems.framework import Context

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import dump_scenario
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.view.meshcat_view import PERIOD
from soft_gripper.diagrams.view.replay import write_replay
from soft_gripper.files import atomic_folder


class Recorder:
    """Writes recordings of a station, each from its own time 0, into folders 1, 2, 3 ... of `folder`.

    Each holds `recording.nc`, every signal; `replay.html`, what Meshcat has shown; and `scenario.yaml`. Logs are kept
    only while something is recorded, so that playing for hours takes no more memory than playing for a minute.
    """

    def __init__(self, station: Station, meshcat: Meshcat, folder: Path):
        self._station, self._meshcat, self._folder = station, meshcat, folder
        self._began: float | None = None

    def elapsed(self, context: Context) -> float | None:
        """Simulated time since the recording began, s; None if there is none."""
        return None if self._began is None else context.get_time() - self._began

    def begin(self, context: Context) -> None:
        """Begins a recording at the present time."""
        self._began = context.get_time()
        self._meshcat.DeleteRecording()
        self._meshcat.StartRecording(frames_per_second=1 / PERIOD)
        # Half a frame before, since Meshcat rounds times down to frames.
        self._meshcat.get_mutable_recording().set_start_time(self._began - PERIOD / 2)
        self._station.logs.clear(context)
        self._station.diagram.ForcedPublish(context)  # the first frame, and the first sample

    def forget(self, context: Context) -> None:
        """Drops what was logged, unless it is being recorded."""
        if self._began is None:
            self._station.logs.clear(context)

    def end(self, context: Context) -> Path | None:
        """Ends the recording, if there is one, and writes it; returns its folder.

        Raises:
            InputError: if it cannot be written.
        """
        if self._began is None:
            return None
        self._began = None
        self._meshcat.StopRecording()
        folder = next(f for f in (self._folder / str(i) for i in count(1)) if not f.exists())
        with atomic_folder(folder) as partial:
            _from_zero(self._station.recording(context)).save(partial / "recording.nc")
            self._meshcat.PublishRecording()
            write_replay(self._meshcat, partial / "replay.html")
            (partial / "scenario.yaml").write_text(dump_scenario(self._station.scenario, partial), encoding="utf-8")
        self._meshcat.SetAnimation(MeshcatAnimation())  # browsers go on showing what happens now
        return folder


def _from_zero(recording: Recording) -> Recording:
    time = recording["time"]
    return Recording(recording.data.assign_coords(time=(time - time[0]).assign_attrs(time.attrs)))
