"""A session: what it opens, and what it records."""

import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from live_station import played
from pydrake.geometry import Meshcat

from soft_gripper.commands.dispatch import dispatch
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import make_simulator
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.page.panel import ALL_FINGERS, Button
from soft_gripper.extras.page.session import Session
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.extras.play import simulation_driver
from soft_gripper.extras.play.commands import play as play_command
from soft_gripper.extras.play.open_scenario import open_scenario
from soft_gripper.extras.play.simulation_driver import Pacer, SimulationDriver, StationRecorder
from soft_gripper.files.output import is_whole
from soft_gripper.interrupts import held_back
from soft_gripper.scenario.checks import check_scenario
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names

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


BEGIN, END = 0.3, 0.6  # s


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Recording, Recording, Path]:
    """A whole run, one that is recorded from BEGIN on, and the folder of that."""
    folder = tmp_path_factory.mktemp("play")
    station, meshcat = played("free_bending")
    found = []
    for is_recorded in (False, True):
        simulator = make_simulator(station)
        context = simulator.get_mutable_context()
        for port in station.parts.inputs:
            station.diagram.GetInputPort(port).FixValue(context, [80e3])
        simulator.AdvanceTo(BEGIN)
        if is_recorded:
            recorder = StationRecorder(station, meshcat, simulator, folder / "1")
            simulator.AdvanceTo(END - BEGIN)
            recorder.end()
        else:
            simulator.AdvanceTo(END)
            found.append(station.recording(context))
    return found[0], Recording.load(folder / "1" / "recording.nc"), folder / "1"


@pytest.mark.parametrize(
    ("signal", "settled"), [("plant.state", 0), ("left_finger.strain", 1), ("left_finger.external_torque", 5)]
)
def test_it_is_that_part_of_the_run(runs, signal: str, settled: int) -> None:
    """`settled` is the number of samples over which what remembers is at first without its past."""
    whole, part, _ = runs
    np.testing.assert_allclose(part[signal][settled:], whole[signal][30 + settled :], atol=1e-9)
    assert np.ptp(part[signal][settled:].values, axis=0).max() > 1e-5, "something happens in it"


def test_everything_to_look_at_it_is_there_and_whole(runs) -> None:
    _, _, folder = runs
    assert folder.name == "1"
    assert is_whole(folder)
    assert "DecompressionStream" in (folder / "animation.html").read_text()
    assert load_scenario(str(folder / "scenario.yaml")).external == ["pressure"]


@pytest.mark.parametrize("name", scenario_names())
def test_every_shipped_scenario_can_be_opened(name: str) -> None:
    scenario = load_scenario(name)
    opened = open_scenario(scenario)
    check_scenario(name, opened)
    grips = scenario.task is not None and scenario.task.grips
    closed_loop = grips or scenario.control.set_points is not None
    assert opened.external == ["opening" if closed_loop else "pressure", *["tool"] * (scenario.arm is not None)]


def test_the_user_chooses_what_commands_the_fingers() -> None:
    assert open_scenario(load_scenario("tip_distance_steps"), "pressure").external == ["pressure"]
    assert open_scenario(load_scenario("box_grasp"), "opening").external == ["opening"]


def test_a_task_that_does_not_command_the_gripper_closes_no_loop() -> None:
    scenario = load_scenario("pick_and_place_box")
    assert scenario.task is not None
    phases = [replace(phase, opening=None) for phase in scenario.task.phases]
    moving = replace(scenario, task=replace(scenario.task, phases=phases))
    assert open_scenario(moving).external == ["pressure", "tool"]
