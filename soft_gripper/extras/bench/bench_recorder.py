"""BenchRecorder: recordings of a bench in numbered folders, written while they go on."""

from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from threading import Thread

from soft_gripper.errors import InputError
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.recorder import Recorder, recording_layout
from soft_gripper.extras.bench.session import Session
from soft_gripper.files.output import next_folder
from soft_gripper.scenario.scenario_file import dump_scenario


class BenchRecorder:
    """Writes recordings of a session into folders 1, 2, 3 ... of `folder`: `recording.nc` and `scenario.yaml`."""

    def __init__(self, session: Session, bench: Bench, signals: Sequence[str], folder: Path):
        """`signals` of the bench are recorded."""
        self._session, self._bench, self._folder = session, bench, folder
        self._layout = recording_layout(bench, signals)
        self._problem = ""
        self._recorders: list[Recorder] = []

    @property
    def is_recording(self) -> bool:
        """Whether a recording is in progress."""
        return self._session.recorder is not None

    @property
    def recordings(self) -> list[Path]:
        """The folders of the recordings that have ended."""
        return [each.path.parent for each in self._recorders if each is not self._session.recorder]

    @property
    def note(self) -> str:
        """Sentence on what became of the last recording."""
        if self._problem or self.is_recording or not self._recorders:
            return self._problem
        return f"written: {self._recorders[-1].report()}"

    def begin(self) -> None:
        """Begins a recording, whose time starts at 0."""
        folder = next_folder(self._folder)
        try:
            folder.mkdir(parents=True)
            self._session.recorder = Recorder(self._bench, self._layout, folder / "recording.nc")
        except (InputError, OSError) as error:
            self._problem = f"not recorded: {error}"
            return
        self._problem = ""
        self._recorders.append(self._session.recorder)
        Thread(target=self._write_scenario, args=(folder,), daemon=True).start()  # it takes longer than a period

    def _write_scenario(self, folder: Path) -> None:
        with suppress(OSError):  # whoever cannot write the recording says so
            (folder / "scenario.yaml").write_text(dump_scenario(self._bench.scenario, folder), encoding="utf-8")

    def end(self) -> None:
        """Ends the recording, if there is one; what is left is written from now on."""
        if self._session.recorder is not None:
            self._session.recorder.end()
            self._session.recorder = None

    def close(self) -> None:
        """Ends the recording, and waits until all are written."""
        self.end()
        for recorder in self._recorders:
            recorder.close()
