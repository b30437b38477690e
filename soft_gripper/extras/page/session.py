"""Session: the hardware of a scenario, simulated or real, in real time, until its user ends it.

A `Driver` moves it on and knows how it is shown; the buttons, the messages to the page and the recordings are the same
for every driver.
"""

import argparse
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any, Protocol

from pydrake.systems.framework import OutputPort

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.page.live_page import SessionPage, page_contents
from soft_gripper.extras.page.page_server import page_server
from soft_gripper.extras.page.panel import Button, Panel
from soft_gripper.extras.page.signal_feed import SignalFeed
from soft_gripper.files.output import next_folder
from soft_gripper.scenario.schema import Scenario


class SessionRecorder(Protocol):
    """A recording in a new folder; once it has ended, its report names the folder and missing samples."""

    @property
    def folder(self) -> Path: ...
    @property
    def is_open(self) -> bool: ...
    @property
    def report(self) -> str: ...
    def end(self) -> None: ...
    def close(self) -> None:
        """Ends the recording, and waits until it is written."""


class Driver(ABC):
    """Interface of a driver of hardware, simulated or real."""

    panel = Panel(())
    signals: Mapping[str, OutputPort] = {}  # that can be plotted, by name
    fingers: Collection[str] = ()  # whose signals share plots
    scene = ""  # address of the Meshcat that is shown
    note = ""  # event since the last click of a button
    summary = ""  # line for the terminal, at the end

    @property
    def is_over(self) -> bool:
        """Whether the session has ended."""
        return False

    def begin(self) -> None:
        """Starts the threads of the driver, if it has any; `close` ends them."""
        return

    @abstractmethod
    def advance(self) -> bool:
        """Advances for a moment of real time; returns whether a frame is due."""

    def frame(self, wanted: Collection[str]) -> tuple[dict[str, Any], dict[str, Array]]:
        """Draws a frame; returns its status, and the values of signals."""
        raise NotImplementedError

    def press(self, button: Button) -> None:
        """Obeys a button other than *record* and *stop*."""
        raise NotImplementedError

    def record(self, folder: Path) -> SessionRecorder:
        """Begins a recording, whose time starts at 0.

        Raises:
            InputError, OSError: if it cannot be written.
        """
        raise NotImplementedError

    def recovers(self) -> bool:
        """Whether a RuntimeError came from a failed view; the driver then goes on without it."""
        return False

    @abstractmethod
    def close(self) -> None:
        """Leaves the hardware in a safe state, however the session ends."""


class Session:
    """Runs a driver frame by frame; a recording in progress is kept however the session ends."""

    def __init__(self, driver: Driver, folder: Path | None = None):
        """`folder` receives the recordings, in folders 1, 2, 3 ...; None: nothing can be recorded."""
        self.driver, self.feed, self._folder = driver, SignalFeed(driver.signals), folder
        self._recorders: list[SessionRecorder] = []
        self._problem, self._is_reported, self._is_stopped = "", False, False

    @property
    def is_recording(self) -> bool:
        """Whether a recording is in progress."""
        return bool(self._recorders) and self._recorders[-1].is_open

    @property
    def recordings(self) -> list[Path]:
        """The folders of the recordings that have ended."""
        return [recorder.folder for recorder in self._recorders if not recorder.is_open and recorder.folder.exists()]

    def run(self, is_over: Callable[[], bool]) -> None:
        """Runs until the user stops the session, `is_over` returns True, or the driver has ended.

        Whatever ends it, the recording is kept, and the hardware is left safe.
        """
        try:
            self.driver.begin()
            while not (is_over() or self._is_stopped or self.driver.is_over):
                self.step()
        except BaseException:
            with suppress(Exception):  # the first error says more
                self._close()
            raise
        self._close()

    def _close(self) -> None:
        try:
            self.driver.close()
        finally:
            for recorder in self._recorders:
                recorder.close()

    def step(self) -> None:
        """Handles button clicks, advances for a moment, and shows a frame if one is due."""
        for button in self.driver.panel.take_clicks():
            self.driver.note = self._problem = ""
            self._with_view(partial(self._react, button))
        if not self._is_stopped:
            self._with_view(self._advance)

    def _with_view(self, act: Callable[[], None]) -> None:
        """Calls an action, and again if the view failed, so that no click is lost."""
        while True:
            try:
                return act()
            except RuntimeError:
                if not self.driver.recovers():
                    raise

    def _advance(self) -> None:
        if self.driver.advance():
            status, values = self.driver.frame(self.feed.wanted_signals)
            self.feed.send({**self._status(), **status}, values)

    def _react(self, button: Button) -> None:
        if button == Button.STOP:
            self._is_stopped = True
        elif button != Button.RECORD:
            self._is_reported = False
            self.driver.press(button)
        elif self.is_recording:
            self._recorders[-1].end()
        else:
            self.record()

    def record(self) -> None:
        """Begins a recording."""
        assert self._folder is not None
        try:
            self._recorders.append(self.driver.record(next_folder(self._folder)))
            self._is_reported = True
        except (InputError, OSError) as error:
            self._problem = f"not recorded: {error}"

    def _status(self) -> dict[str, Any]:
        has_report = self._is_reported and not self.is_recording
        notes = self.driver.note, self._problem, self._recorders[-1].report if has_report else ""
        return {
            "recording": self.is_recording,
            "note": "; ".join(filter(None, notes)),
            "sliders": self.driver.panel.values,
        }


def serve_session(
    session: Session,
    command: str,
    options: argparse.Namespace,
    scenario: Scenario,
    is_over: Callable[[], bool],
    say: Callable[[str], object],
) -> None:
    """Runs the session of a command, whose options name the scenario and the host, behind its page.

    `say` takes lines for the terminal.

    Raises:
        InputError: if the page cannot be served there, or as `Session.run`.
    """
    driver, name = session.driver, Path(options.scenario).stem
    contents = page_contents(command, name, scenario, driver.panel, driver.signals, driver.fingers)
    page = SessionPage(contents, driver.panel, session.feed)
    with page_server(options.host, lambda: driver.scene, page) as address:
        say(f"Open {address} in a browser. The 'stop' button there, or Ctrl-C here, ends the session.")
        try:
            session.run(is_over)
        finally:
            if driver.summary:
                say(driver.summary)
            if page.refused:
                say(f"Rejected {page.refused} messages that were not valid commands.")
            say(f"Recordings: {', '.join(map(str, session.recordings)) or 'none.'}")
