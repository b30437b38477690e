"""Where the output goes, and what comes in: none of it ends in a traceback."""

import errno
import fcntl
import io
import logging
import os
import signal
import subprocess
import sys
import warnings
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace

import pytest
from command_line import soft_gripper

from soft_gripper.commands import main
from soft_gripper.errors import SimulationDivergedError, WorkerDiedError
from soft_gripper.files.output import lock_folder
from soft_gripper.library_messages import printed_as_notes
from soft_gripper.models import DIRECTORY

COMMAND = [sys.executable, "-c", "import sys; from soft_gripper.commands import main; sys.exit(main())"]


class Full(io.StringIO):
    """A stream onto a disk that is full."""

    def write(self, text: str) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


class Buffered(io.StringIO):
    """One whose buffer takes everything, until it is to be written."""

    def flush(self) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


@pytest.mark.parametrize("stream", [Full, Buffered])
def test_output_onto_a_full_disk(stream: type[io.StringIO], monkeypatch, capsys) -> None:
    monkeypatch.setattr(sys, "stdout", stream())
    assert main(["show", "free_bending"]) == 2
    assert capsys.readouterr().err == "soft-gripper: output: No space left on device\n"


@pytest.mark.slow
def test_a_reader_that_is_gone(tmp_path: Path) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    try:
        found = subprocess.run([*COMMAND, "show", "free_bending"], stdout=writing, stderr=subprocess.PIPE, check=False)
    finally:
        os.close(writing)
    assert (found.returncode, found.stderr) == (141, b"")


@pytest.mark.slow
def test_a_terminal_that_cannot_show_a_character(tmp_path: Path) -> None:
    environment = os.environ | {"PYTHONIOENCODING": "ascii"}
    finger = (DIRECTORY / "grippers" / "finger.urdf").read_text()
    (tmp_path / "a.urdf").write_text(finger.replace("</robot>", "<!-- 5 \N{DEGREE SIGN} --></robot>"), encoding="utf-8")
    command = [*COMMAND, "expand", str(tmp_path / "a.urdf")]
    found = subprocess.run(command, capture_output=True, env=environment, check=False)
    assert (found.returncode, found.stderr) == (0, b"")
    assert b"5 \\xb0" in found.stdout


def test_complaints_of_libraries_become_notes(capsys) -> None:
    drake = logging.getLogger("drake")
    before = logging.getLogger().handlers[:], drake.handlers[:], drake.level
    with printed_as_notes():
        for _ in range(2):
            drake.warning("/tmp/soft-gripper-x/o.expanded.urdf:4: warning: a\n   b")
        warnings.warn("overflow encountered in multiply", RuntimeWarning, stacklevel=1)
        logging.getLogger("trimesh").info("something")
        for i in range(10):
            drake.warning("more %d", i)
    lines = capsys.readouterr().err.splitlines()
    assert lines[:2] == [
        "note: o.urdf:4: warning: a b",
        "note: numbers out of range: overflow encountered in multiply",
    ]
    assert lines[2:] == ["note: more 0", "note: more 1", "note: more 2", "note: ... and more"]
    assert before == (logging.getLogger().handlers, drake.handlers, drake.level)


def code_with(handlers: dict[signal.Signals, signal.Handlers]) -> object:
    """The code with which a command exits where signals have these handlers."""
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    try:
        with pytest.raises(SystemExit) as caught:
            soft_gripper("show", "free_bending")
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    return caught.value.code


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGHUP, 129)])
def test_a_signal_in_the_middle_of_a_command_ends_it_with_the_code_of_the_signal(number, code, monkeypatch) -> None:
    def end(*_: object) -> None:
        try:
            signal.raise_signal(number)
        finally:
            if number == signal.SIGHUP:
                signal.raise_signal(number)  # again, while it cleans up

    monkeypatch.setattr("soft_gripper.commands.chosen_station.make_station", end)
    # Below nohup the suite itself has SIGHUP ignored.
    assert code_with({signal.SIGTERM: signal.SIG_DFL, signal.SIGHUP: signal.SIG_DFL}) == code


def test_a_signal_while_modules_are_imported_is_obeyed_though_libraries_swallow_exceptions(monkeypatch) -> None:
    def swallowing(name: str) -> object:
        with suppress(BaseException):  # as scipy does around its optional imports
            signal.raise_signal(signal.SIGTERM)
        return SimpleNamespace(run=lambda options: None)

    monkeypatch.setattr(sys.modules["soft_gripper.commands.dispatch"], "import_module", swallowing)
    assert code_with({signal.SIGTERM: signal.SIG_DFL}) == 143


def test_sighup_is_ignored_below_nohup(monkeypatch) -> None:
    monkeypatch.setattr(
        "soft_gripper.commands.chosen_station.make_station",
        lambda *_: signal.raise_signal(signal.SIGHUP) or sys.exit(3),
    )
    assert code_with({signal.SIGHUP: signal.SIG_IGN}) == 3


@pytest.mark.parametrize(
    ("closed", "code", "says"),
    [
        (">&-", 2, b"soft-gripper: output: Bad file descriptor\n"),
        ("2>&- <&-", 0, b""),
        (">&- 2>&-", 2, b""),
        (">/dev/full 2>/dev/full", 2, b""),
    ],
)
def test_standard_streams_that_are_closed_or_full(closed: str, code: int, says: bytes) -> None:
    command = ["bash", "-c", f'exec "$@" {closed}', "bash", *COMMAND, "list"]
    found = subprocess.run(command, capture_output=True, check=False)
    assert (found.returncode, found.stderr) == (code, says)


@pytest.mark.parametrize(
    "error",
    [
        OSError(errno.EIO, "broken", "a.txt"),
        MemoryError(),
        WorkerDiedError("died"),
        SimulationDivergedError("diverged"),
        SystemExit("Failure at x.cc:1 in F(): condition 'a > 0' failed."),  # of Drake
    ],
)
def test_what_the_machine_does_not_bear(error: BaseException, monkeypatch, tmp_path: Path) -> None:
    def fail(*_: object) -> None:
        lock_folder(tmp_path)
        raise error

    monkeypatch.setattr("soft_gripper.commands.chosen_station.make_station", fail)
    outcome = soft_gripper("show", "free_bending")
    assert (outcome.code, outcome.err.count("\n")) == (2, 1)
    lock = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)  # what was claimed is free again
    os.close(lock)


def test_ctrl_c_while_the_command_line_is_imported_is_one_line() -> None:
    """Python itself starts in some 50 ms, before which nothing can answer."""
    script = """if True:
        import builtins, os, signal, sys
        from soft_gripper.commands import main
        signal.signal(signal.SIGINT, signal.default_int_handler)  # it may be ignored where the tests run
        load = builtins.__import__
        def interrupted(name, *rest):
            os.kill(os.getpid(), signal.SIGINT)
            builtins.__import__ = load
            return load(name, *rest)
        builtins.__import__ = interrupted
        sys.exit(main(["show", "free_bending"]))"""
    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert found.stderr == "soft-gripper: interrupted; all files already written are complete\n"
    assert (found.returncode, found.stdout) == (130, "")


def test_a_name_that_is_not_utf_8_is_refused(tmp_path: Path) -> None:
    file = os.fsencode(tmp_path / "a") + b"\xff.yaml"
    Path(os.fsdecode(file)).write_text("models: []")
    found = subprocess.run([*map(os.fsencode, COMMAND), b"show", file], capture_output=True, check=False)
    assert found.returncode == 2
    assert found.stderr.startswith(b"soft-gripper: command line: argument = ")
    assert found.stderr.endswith(b"is not UTF-8: give files names that are\n")
