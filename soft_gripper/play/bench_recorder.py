"""BenchRecorder: recordings of a bench, written while it goes on."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import xarray as xr

from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_folder
from soft_gripper.hardware.live.bench import Bench
from soft_gripper.play.session import next_folder
from soft_gripper.scenario.scenario_file import dump_scenario

_MOST_KEPT = 100  # samples that are logged while nothing is recorded


class BenchRecorder:
    """Writes recordings of a bench into folders 1, 2, 3 ... of `folder`: `recording.nc` and `scenario.yaml`.

    Samples are kept during a recording alone. Another thread writes it; estimates and commands go on meanwhile.
    """

    def __init__(self, bench: Bench, folder: Path):
        """`bench` is one that records."""
        self._bench, self._folder, self._kept = bench, folder, 0
        self._writer = ThreadPoolExecutor(1)
        self.is_recording, self.note = False, ""
        self.recordings: list[Path] = []
        # Imports what writes a recording now; xarray defers most of that, half a second, until it is used.
        xr.Dataset({"time": [0.0]}).to_netcdf()

    def begin(self) -> None:
        """Begins a recording, whose time starts at 0."""
        self._bench.forget()
        self.is_recording, self.note = True, ""

    def forget(self) -> None:
        """Forgets old samples, unless a recording is in progress."""
        self._kept += 1
        if not self.is_recording and self._kept >= _MOST_KEPT:
            self._kept = 0
            self._bench.forget()

    def end(self) -> None:
        """Ends the recording, if there is one; it is written from now on."""
        if self.is_recording:
            self.is_recording, self.note = False, "writing the recording"
            self._writer.submit(self._write, self._bench.recorded())

    def close(self) -> None:
        """Ends the recording, and waits until all are written."""
        self.end()
        self._writer.shutdown()

    def _write(self, recorded: Callable[[], Recording]) -> None:
        folder = next_folder(self._folder)
        try:
            with atomic_folder(folder) as partial:
                data = recorded().data
                time = data["time"]
                from_zero = ("time", time.values - time.values[:1], time.attrs)
                Recording(data.assign_coords(time=from_zero)).save(partial / "recording.nc")
                (partial / "scenario.yaml").write_text(dump_scenario(self._bench.scenario, partial), encoding="utf-8")
        except (InputError, OSError) as error:
            self.note = f"not written: {error}"
        else:
            self.recordings.append(folder)
            self.note = f"written: {folder}"
