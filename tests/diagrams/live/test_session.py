"""A session, its user's clicks coming between the frames as a browser would send them."""

import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from live_station import click, move, played
from pydrake.geometry import Meshcat

from soft_gripper.diagrams.live import session as session_module
from soft_gripper.diagrams.live.control_panel import ALL_FINGERS, Button
from soft_gripper.diagrams.live.pacer import Pacer
from soft_gripper.diagrams.live.recorder import Recorder
from soft_gripper.diagrams.live.session import Session
from soft_gripper.diagrams.live.signal_feed import SignalFeed
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, SimulationDivergedError

PRESSURE = "left_finger.pressure"
Play = Callable[..., tuple[Session, list[dict]]]


class Watched(SignalFeed):
    """What was sent, and what its user does then."""

    def __init__(self, meshcat: Meshcat, user: dict[int, Callable[[], None]]):
        super().__init__({PRESSURE})
        self.sent: list[dict] = []
        self._meshcat, self._user = meshcat, user

    @property
    def wanted(self) -> set[str]:
        return {PRESSURE}

    def send(self, status, values) -> None:
        self.sent.append({**status, **{name: float(value[0]) for name, value in values.items()}})
        self._user.pop(len(self.sent), lambda: None)()
        if not self._user:
            click(self._meshcat, Button.STOP)


@pytest.fixture(scope="module")
def shown() -> tuple[Station, Meshcat]:
    return played("free_bending")


@pytest.fixture
def play(shown, tmp_path: Path, monkeypatch) -> Play:
    """Plays until the last of what the user does, by the number of the message after which it is done."""
    station, meshcat = shown
    monkeypatch.setattr(session_module, "_IDLE", 0.0)

    def play(**user: object) -> tuple[Session, list[dict]]:
        feed = Watched(meshcat, {int(number[1:]): action for number, action in user.items()})
        meshcat.DeleteAddedControls()
        session = Session(station, meshcat, feed, Recorder(station, meshcat, tmp_path))
        session.run()
        return session, feed.sent

    return play


def test_pressure_follows_the_slider_in_real_time(shown, play: Play) -> None:
    session, sent = play(_2=lambda: move(shown[1], ALL_FINGERS, 50.0), _12=lambda: None)
    assert [each["time"] for each in sent] == pytest.approx([0.05 * i for i in range(1, 13)])
    assert sent[1][PRESSURE] == 0
    assert 45e3 < sent[-1][PRESSURE] < 50e3
    assert session.played == pytest.approx(0.6)
    assert 0.3 < session.factor <= 1.05


def test_time_stands_still_in_a_pause_and_is_not_made_up_for(shown, play: Play, monkeypatch) -> None:
    restart, restarted = Pacer.restart, []
    monkeypatch.setattr(Pacer, "restart", lambda pacer, time: (restarted.append(time), restart(pacer, time)))
    pause = lambda: click(shown[1], Button.PAUSE)  # noqa: E731
    _, sent = play(_2=pause, _6=pause, _8=lambda: None)
    assert [each["paused"] for each in sent] == [False] * 2 + [True] * 4 + [False] * 2
    assert [each["time"] for each in sent] == pytest.approx([0.05, 0.1, 0.1, 0.1, 0.1, 0.1, 0.15, 0.2])
    assert restarted == pytest.approx([0.0, 0.1, 0.1])


def test_reset_begins_again(shown, play: Play) -> None:
    def reset() -> None:
        click(shown[1], Button.RESET)

    _, sent = play(_1=lambda: move(shown[1], ALL_FINGERS, 50.0), _4=reset, _6=lambda: None)
    assert [each["time"] for each in sent] == pytest.approx([0.05, 0.1, 0.15, 0.2, 0.05, 0.1])
    assert sent[3][PRESSURE] > 30e3
    assert sent[4][PRESSURE] == sent[0][PRESSURE] == 0


def test_what_is_played_for_hours_is_not_kept(play: Play, monkeypatch) -> None:
    forgotten = []
    monkeypatch.setattr(Recorder, "forget", lambda _, context: forgotten.append(context.get_time()))
    _, sent = play(_8=lambda: None)
    assert forgotten == [each["time"] for each in sent]


def test_a_recording_in_a_pause_is_of_the_sample_that_is_seen(shown, play: Play, tmp_path: Path) -> None:
    record = lambda: click(shown[1], Button.RECORD)  # noqa: E731
    _, sent = play(_1=lambda: click(shown[1], Button.PAUSE), _2=record, _4=record, _6=lambda: None)
    assert sent[-1]["note"] == f"written: {tmp_path / '1'}"
    assert Recording.load(tmp_path / "1" / "recording.nc")["time"].values.tolist() == [0.0]


@pytest.mark.parametrize("error", [InputError("output", "folder", "a", "give another"), OSError("no space")])
def test_a_recording_that_cannot_be_written_is_no_end(shown, play: Play, monkeypatch, error: Exception) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(Recorder, "end", fail)
    record = lambda: click(shown[1], Button.RECORD)  # noqa: E731
    _, sent = play(_1=record, _2=record, _4=lambda: None)
    assert [each["note"] for each in sent] == ["", "", *[f"not written: {error}"] * 2]


def test_a_recording_goes_from_click_to_click(shown, play: Play, tmp_path: Path) -> None:
    record = lambda: click(shown[1], Button.RECORD)  # noqa: E731
    _, sent = play(_2=record, _6=record, _8=lambda: None)
    assert [each["recording"] for each in sent] == [False] * 2 + [True] * 4 + [False] * 2
    assert sent[-1]["note"] == f"written: {tmp_path / '1'}"
    assert Recording.load(tmp_path / "1" / "recording.nc")["time"][-1] == pytest.approx(0.2)


def test_every_recording_has_a_folder_of_its_own(shown, play: Play, tmp_path: Path) -> None:
    record = lambda: click(shown[1], Button.RECORD)  # noqa: E731
    _, sent = play(_1=record, _2=record, _3=record, _5=record, _6=lambda: None)
    assert sent[-1]["note"] == f"written: {tmp_path / '2'}"
    ends = [Recording.load(tmp_path / number / "recording.nc")["time"][-1] for number in ("1", "2")]
    assert ends == pytest.approx([0.05, 0.1])


def test_reset_ends_a_recording(shown, play: Play, tmp_path: Path) -> None:
    _, sent = play(_1=lambda: click(shown[1], Button.RECORD), _3=lambda: click(shown[1], Button.RESET), _4=lambda: None)
    assert [each["recording"] for each in sent] == [False, True, True, False]
    assert Recording.load(tmp_path / "1" / "recording.nc")["time"][-1] == pytest.approx(0.1)


def test_a_recording_is_written_when_the_session_ends(shown, play: Play, tmp_path: Path) -> None:
    def end() -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        play(_1=lambda: click(shown[1], Button.RECORD), _3=end)
    assert (tmp_path / "1" / "replay.html").exists()


def test_ctrl_c_in_the_middle_of_a_frame_waits_for_its_end(shown, play: Play, tmp_path: Path, monkeypatch) -> None:
    real = session_module.advance

    def interrupted(simulator, station, time) -> None:
        real(simulator, station, time)
        if time > 0.12:
            signal.raise_signal(signal.SIGINT)
            simulator.get_context()  # where Python would notice

    monkeypatch.setattr(session_module, "advance", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell's background jobs do without
    try:
        with pytest.raises(KeyboardInterrupt):
            play(_1=lambda: click(shown[1], Button.RECORD), _9=lambda: None)
    finally:
        signal.signal(signal.SIGINT, before)
    assert Recording.load(tmp_path / "1" / "recording.nc")["time"][-1] == pytest.approx(0.15)


def test_divergence_is_reported_and_reset_goes_on(shown, play: Play, monkeypatch) -> None:
    real = session_module.advance

    def diverge(simulator, station, time) -> None:
        if time > 0.12:
            raise SimulationDivergedError("the simulation diverged")
        real(simulator, station, time)

    monkeypatch.setattr(session_module, "advance", diverge)
    _, sent = play(_4=lambda: click(shown[1], Button.RESET), _5=lambda: None)
    assert [each["note"] for each in sent] == ["", "", "the simulation diverged", "the simulation diverged", ""]
    assert [each["paused"] for each in sent] == [False, False, True, True, False]
