"""Recorder: a recording of a bench that is written while it goes on, row by row.

The file is netCDF 3 with an unlimited dimension of time: a row is appended for every sample, and then the number of
rows in the header is raised. So it can be read at any time, and whatever ends the session, it has all rows up to the
last that was written. What is appended reaches the disk before the number does.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Event, Thread
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.provenance import provenance
from soft_gripper.diagrams.recording import make_recording
from soft_gripper.diagrams.signal_labels import labels_of
from soft_gripper.diagrams.signal_sources import LoggedPort, Samples
from soft_gripper.errors import InputError
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.threads import LINGER, write_all
from soft_gripper.signals import Signal, signal_of

COUNT, DEVICE_TIME = "reading.count", "reading.time"
_READING_SIGNALS = {COUNT: Signal(), DEVICE_TIME: Signal("s")}
_WRITE_PERIOD = 0.25  # s between writes
_MAX_ROWS = 6000  # that wait for a slow disk
_NUMBER_TYPE = np.dtype(">f8")  # netCDF 3 is big-endian
_ROW_COUNT_OFFSET = 4  # bytes before the number of rows in a header


class RowLayout(NamedTuple):
    """Layout of the rows of a recording."""

    signals: list[str]  # of a bench
    header: bytes  # of a recording without rows
    order: NDArray[np.int_]  # in which time, signals, number and time of the reading make a row


def recording_layout(bench: Bench, signals: Sequence[str]) -> RowLayout:
    """The layout of recordings that have these signals of a bench.

    It is derived from files of one and two rows, whose numbers are their indices.
    """
    descriptors = {name: signal_of(bench.signals[name]) for name in signals} | _READING_SIGNALS
    sizes = [1, *(bench.signals[name].size() for name in signals), *[1] * len(_READING_SIGNALS)]
    attributes = provenance(bench.scenario, bench.scenario.sensor.type, bench.scenario.estimator.type)
    index_groups = np.split(np.arange(float(sum(sizes))), np.cumsum(sizes)[:-1])
    files = []
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        for rows in (1, 2):
            values = {i: np.tile(indices, (rows, 1)) for i, indices in enumerate(index_groups[1:])}
            sources = {name: LoggedPort(i) for i, name in enumerate(descriptors)}
            recording = make_recording(labels_of(descriptors), Samples(sources, np.zeros(rows), values), attributes)
            path = Path(folder) / "layout.nc"
            recording.data.to_netcdf(path, engine="scipy", format="NETCDF3_64BIT", unlimited_dims=["time"])
            files.append(path.read_bytes())
    row = _NUMBER_TYPE.itemsize * sum(sizes)
    assert len(files[1]) - len(files[0]) == row, "a row has these numbers alone"
    header = bytearray(files[0][:-row])
    header[_ROW_COUNT_OFFSET : _ROW_COUNT_OFFSET + 4] = bytes(4)
    return RowLayout([*signals], bytes(header), np.frombuffer(files[0][-row:], _NUMBER_TYPE).astype(int))


class Recorder:
    """Writes signals of a bench at every sample, in a separate thread; counts samples lost to a slow disk."""

    def __init__(self, bench: Bench, layout: RowLayout, path: Path):
        """`path` names a new file.

        Raises:
            InputError: if it cannot be written.
        """
        self.path, self.folder, self.problem, self.lost = path, path.parent, "", 0
        self._bench, self._layout, self._samples = bench, layout, 0
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o666)
            write_all(self._file, layout.header)
        except OSError as error:
            raise InputError("live", "recording", str(path), f"cannot be written: {error.strerror}") from None
        self._rows, self._written, self._ends = list[bytes](), 0, Event()
        self._thread = Thread(target=self._run, daemon=True)
        self._thread.start()

    def take(self, count: float, device_time: float) -> None:
        """Records the last sample of the bench, with number and time, s, of its reading; NaN if that is missing."""
        self._put(np.concatenate([*self._bench.read(self._layout.signals).values(), [count], [device_time]]))

    def pass_over(self, samples: int) -> None:
        """Records samples without values."""
        for _ in range(samples):
            self._put(np.full(len(self._layout.order) - 1, np.nan))

    def _put(self, values: Array) -> None:
        row = np.append(self._samples * self._bench.period, values)
        self._samples += 1
        if self.problem or len(self._rows) >= _MAX_ROWS:
            self.lost += 1
        else:
            self._rows.append(row[self._layout.order].astype(_NUMBER_TYPE).tobytes())

    @property
    def is_open(self) -> bool:
        """Whether samples are recorded."""
        return not self._ends.is_set()

    def end(self) -> None:
        """Tells the thread to write the remaining rows and end, without waiting for it."""
        self._ends.set()

    def close(self) -> None:
        """Ends the recording, and waits until it is written; gives up on a disk that is too slow."""
        self.end()
        self._thread.join(5 * LINGER)
        if self._thread.is_alive():
            self.problem = "the disk is too slow"
            self.lost += len(self._rows)

    @property
    def report(self) -> str:
        """Path of the recording, and the number of missing samples, in words."""
        if self._thread.is_alive() and not self.problem:
            return "being written"
        loss_text = f"; {self.lost} samples are missing: {self.problem or 'the disk is too slow'}" if self.lost else ""
        return f"written: {self.path}{loss_text}"

    def _run(self) -> None:
        try:
            while not self._ends.wait(_WRITE_PERIOD):
                self._write()
            self._write()
        except OSError as error:  # the disk is full, or gone
            self.problem = error.strerror or str(error)
            self.lost += len(self._rows)
        finally:
            os.close(self._file)

    def _write(self) -> None:
        count = len(self._rows)
        if not count:
            return
        write_all(self._file, b"".join(self._rows[:count]))
        del self._rows[:count]
        os.fsync(self._file)
        self._written += count
        os.pwrite(self._file, self._written.to_bytes(4, "big"), _ROW_COUNT_OFFSET)


def free_name(path: Path) -> Path:
    """First unused path: the given one, or with a number after its stem, so that no recording is replaced."""
    numbered_paths = (path.with_name(f"{path.stem}_{i}{path.suffix}") for i in range(2, 10**6))
    return next(candidate for candidate in (path, *numbered_paths) if not candidate.exists()) if path.exists() else path
