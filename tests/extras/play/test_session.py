"""A session, its user's clicks coming between the frames as a browser would send them."""

import signal
from collections.abc import Callable
from pathlib import Path

import pytest
from live_station import played
from pydrake.geometry import Meshcat

from soft_gripper.commands.dispatch import dispatch
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.page.panel import ALL_FINGERS, Button
from soft_gripper.extras.page.session import Session
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.extras.play import simulation_driver
from soft_gripper.extras.play.commands import play as play_command
from soft_gripper.extras.play.pacer import Pacer
from soft_gripper.extras.play.simulation_driver import SimulationDriver
from soft_gripper.extras.play.station_recorder import StationRecorder
from soft_gripper.interrupts import held_back

PRESSURE = "left_finger.pressure"
User = Callable[[Session], object]  # does something
Play = Callable[..., tuple[Session, list[dict]]]


class Watched(SignalFeed):
    """What was sent, and what its user does then."""

    def __init__(self, session: Session, user: dict[int, User]):
        super().__init__({PRESSURE})
        self.sent: list[dict] = []
        self._session, self._user = session, user

    @property
    def wanted_signals(self) -> set[str]:
        return {PRESSURE}

    def send(self, status, values) -> None:
        self.sent.append({**status, **{name: float(value[0]) for name, value in values.items()}})
        self._user.pop(len(self.sent), nothing)(self._session)
        if not self._user:
            click(Button.STOP)(self._session)


def nothing(_: Session) -> None:
    """What a user does who looks on."""


def click(button: Button) -> User:
    return lambda session: session.driver.panel.take({"button": str(button)})


def move(slider: str, value: float) -> User:
    return lambda session: session.driver.panel.take({"slider": slider, "value": value})


pause, reset, record = click(Button.PAUSE), click(Button.RESET), click(Button.RECORD)


def end_time(folder: Path) -> float:
    """Of a recording, s."""
    return float(Recording.load(folder / "recording.nc")["time"][-1])


@pytest.fixture(scope="module")
def shown() -> tuple[Station, Meshcat]:
    return played("free_bending")


@pytest.fixture
def play(shown, tmp_path: Path, monkeypatch) -> Play:
    """Plays until the last of what the user does, by the number of the message after which it is done."""
    station, meshcat = shown
    monkeypatch.setattr(simulation_driver, "_PAUSE_PERIOD", 0.0)
    monkeypatch.setattr(simulation_driver, "hidden_meshcat", lambda: meshcat)

    def play(is_over: Callable[[], bool] = lambda: False, **user: User) -> tuple[Session, list[dict]]:
        session = Session(SimulationDriver(lambda _: station), tmp_path)
        session.feed = feed = Watched(session, {int(number[1:]): action for number, action in user.items()})
        session.run(is_over)
        return session, feed.sent

    return play


def test_pressure_follows_the_slider_in_real_time(play: Play) -> None:
    session, sent = play(_2=move(ALL_FINGERS, 50.0), _12=nothing)
    assert [each["time"] for each in sent] == pytest.approx([0.05 * i for i in range(1, 13)])
    assert sent[1][PRESSURE] == 0
    assert 45e3 < sent[-1][PRESSURE] < 50e3
    assert session.driver.pacer.played == pytest.approx(0.6)
    assert 0.3 < session.driver.pacer.whole_factor <= 1.05


def test_time_stands_still_in_a_pause_and_is_not_made_up_for(play: Play, monkeypatch) -> None:
    restart, restarted = Pacer.restart, []
    monkeypatch.setattr(Pacer, "restart", lambda pacer, time: (restarted.append(time), restart(pacer, time)))
    _, sent = play(_2=pause, _6=pause, _8=nothing)
    assert [each["paused"] for each in sent] == [False] * 2 + [True] * 4 + [False] * 2
    assert [each["time"] for each in sent] == pytest.approx([0.05, 0.1, 0.1, 0.1, 0.1, 0.1, 0.15, 0.2])
    assert restarted == pytest.approx([0.0, 0.1, 0.1])


def test_reset_begins_again(play: Play) -> None:
    _, sent = play(_1=move(ALL_FINGERS, 50.0), _4=reset, _6=nothing)
    assert [each["time"] for each in sent] == pytest.approx([0.05, 0.1, 0.15, 0.2, 0.05, 0.1])
    assert sent[3][PRESSURE] > 30e3
    assert sent[4][PRESSURE] == sent[0][PRESSURE] == 0


@pytest.mark.parametrize("error", [InputError("output", "folder", "a", "give another"), OSError("no space")])
def test_a_recording_that_cannot_be_written_is_no_end(play: Play, monkeypatch, error: Exception) -> None:
    def fail(*_: object) -> None:
        raise error

    monkeypatch.setattr(StationRecorder, "_write", fail)
    _, sent = play(_1=record, _2=record, _4=nothing)
    assert [each["note"] for each in sent] == ["", "", *[f"not written: {error}"] * 2]


def test_a_recording_is_written_whatever_ends_the_session(play: Play, tmp_path: Path) -> None:
    def fail(_: Session) -> None:
        raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011
        play(_1=record, _3=fail)
    assert end_time(tmp_path / "1") == pytest.approx(0.1)


def test_ctrl_c_in_the_middle_of_a_frame_waits_for_its_end(play: Play, tmp_path: Path, monkeypatch) -> None:
    real = simulation_driver.advance

    def interrupted(simulator, station, time) -> None:
        real(simulator, station, time)
        if time > 0.12:
            signal.raise_signal(signal.SIGINT)
            simulator.get_context()  # where Python would notice

    monkeypatch.setattr(simulation_driver, "advance", interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # which a shell's background jobs do without
    try:
        with held_back() as is_interrupted:
            play(is_interrupted, _1=record, _9=nothing)
    finally:
        signal.signal(signal.SIGINT, before)
    assert end_time(tmp_path / "1") == pytest.approx(0.15)


def test_divergence_is_reported_and_reset_goes_on(play: Play, monkeypatch) -> None:
    real = simulation_driver.advance

    def diverge(simulator, station, time) -> None:
        if time > 0.12:
            raise SimulationDivergedError("the simulation diverged")
        real(simulator, station, time)

    monkeypatch.setattr(simulation_driver, "advance", diverge)
    _, sent = play(_4=reset, _5=nothing)
    assert [each["note"] for each in sent] == ["", "", "the simulation diverged", "the simulation diverged", ""]
    assert [each["paused"] for each in sent] == [False, False, True, True, False]


def test_the_command_shows_what_is_estimated(monkeypatch, tmp_path):
    """Its station is the whole one, in the Meshcat of its page."""
    sessions = []
    monkeypatch.setattr(play_command, "serve_session", lambda session, *_: sessions.append(session))
    assert dispatch(["play", "free_bending", "--out", str(tmp_path / "out")]) == 0
    (session,) = sessions
    assert {PRESSURE, "left_finger.theta", "left_finger.external_torque"} <= set(session.driver.signals)
    assert session.driver.scene.startswith("http")
    session.driver.close()
