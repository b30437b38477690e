"""The command line in a forked child for every call: quick, and neither a crash nor a hang reaches the tests.

A child of this file imports the project once, and forks for every call that it is told of.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

MEMORY = 6 * 2**30  # bytes of addresses that a call may take


@dataclass(frozen=True)
class Ended:
    """How a call ended, and what it said. A negative code is the signal that ended it; None: its time was over."""

    code: int | None
    out: str
    err: str
    seconds: float
    cpu: float = 0.0  # s of the processor
    memory: float = 0.0  # MB, at most at once, those of the imported libraries among them


class Sandbox:
    """Calls of the command line in children, each in a folder and with a time limit."""

    def __init__(self) -> None:
        self._server = subprocess.Popen(
            [sys.executable, "-u", __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )

    def call(self, arguments: list[str], folder: Path, limit: float = 60.0) -> Ended:
        """Runs `soft-gripper ARGUMENTS` in `folder`, for `limit` s at most."""
        assert self._server.stdin is not None
        assert self._server.stdout is not None
        self._server.stdin.write(json.dumps([arguments, str(folder), limit]) + "\n")
        self._server.stdin.flush()
        answer = self._server.stdout.readline()
        return Ended(**json.loads(answer))

    def close(self) -> None:
        """Ends the server."""
        assert self._server.stdin is not None
        self._server.stdin.close()
        self._server.wait()


def _serve() -> None:
    from soft_gripper.commands.parser import commands

    for command in commands():  # everything is imported once, before the forks
        import_module(command.module)

    for line in sys.stdin:
        print(json.dumps(_in_child(*json.loads(line))), flush=True)


def _in_child(arguments: list[str], folder: str, limit: float) -> dict[str, Any]:
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err, tempfile.TemporaryFile() as nothing:
        begin = time.monotonic()
        child = os.fork()
        if child == 0:
            _become_command(arguments, folder, nothing.fileno(), out.fileno(), err.fileno())
        code, usage = _wait(child, begin + limit)
        seconds = time.monotonic() - begin
        out.seek(0)
        err.seek(0)
        texts = (file.read().decode(errors="replace") for file in (out, err))
        used = {"cpu": usage.ru_utime + usage.ru_stime, "memory": usage.ru_maxrss / 1e3}
        return {"code": code, "out": next(texts), "err": next(texts), "seconds": seconds} | used


def _wait(child: int, deadline: float) -> tuple[int | None, resource.struct_rusage]:
    while time.monotonic() < deadline:
        found, status, usage = os.wait4(child, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status), usage
        time.sleep(0.005)
    os.killpg(child, signal.SIGKILL)
    return None, os.wait4(child, 0)[2]


def _become_command(arguments: list[str], folder: str, nothing: int, out: int, err: int) -> None:
    """Ends with the process: as the installed script does, with its streams and its exit code."""
    import traceback

    from soft_gripper.commands import main

    os.setpgid(0, 0)
    os.dup2(out, 1)
    os.dup2(err, 2)
    os.dup2(nothing, 0)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    os.chdir(folder)
    code = 1
    try:
        code = main(arguments)
    except SystemExit as error:
        if isinstance(error.code, str):
            print(error.code, file=sys.stderr)
        else:
            code = error.code or 0
    except BaseException:
        traceback.print_exc()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


if __name__ == "__main__":
    _serve()
