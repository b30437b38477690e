"""A user's estimator in a process of its own, which is given nothing of what is tested but the inputs.

The process has its own memory, a short list of variables, no word of the command line, and, after the import of the
user's module, an empty current folder. Where the system has Landlock, it cannot open the files of the tasks. What it
answers is JSON, which cannot run code here.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import count
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from signal import SIGKILL, strsignal
from tempfile import TemporaryDirectory
from typing import Any

from tqdm import tqdm

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, described
from soft_gripper.registry import OWN
from soft_gripper.runs.executor import begin
from studies.benchmark.benchmark_task import Estimator, Predict, Predicted, Question, Recorded
from studies.benchmark.estimates import checked, mean_and_std

_PATIENCE = 60  # s without an answer, after which that is said
_MOST_BYTES = 2**30  # of an answer
_VARIABLES = (
    *("HOME", "PATH", "LANG", "LC_ALL", "TMPDIR", "LD_LIBRARY_PATH", "CUDA_VISIBLE_DEVICES"),
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"),
)
_BEGIN = """
import sys
from multiprocessing.connection import Connection
parent, line = (Connection(int(end)) for end in sys.argv[1:])
del sys.argv[1:]
sys.path[:] = parent.recv()
from studies.benchmark.hidden_folders import hide
is_hidden = hide(parent.recv())
from studies.benchmark.user_estimator import serve
serve(parent, line, is_hidden, *parent.recv())
"""


@contextmanager
def user_estimator(name: str, hidden: Collection[Path]) -> Iterator[tuple[Estimator, bool]]:
    """A user's estimator, in a process that ends with the block, and whether it cannot read the hidden paths.

    Args:
        name: "module:function" or "file.py:function".
        hidden: files, and folders with all that is in them.

    Raises:
        InputError: if it cannot be imported, or, when it is called, if it fails, ends its process, or does not return
            what it must.
    """
    parent, child = Pipe()
    line, end = Pipe(duplex=False)
    environment = {key: os.environ[key] for key in _VARIABLES if key in os.environ}
    with TemporaryDirectory(prefix="soft-gripper-", ignore_cleanup_errors=True) as folder, parent, end:
        with child, line:
            process = subprocess.Popen(
                [sys.executable, "-I", "-u", "-c", _BEGIN, str(child.fileno()), str(line.fileno())],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=2,  # standard output is for the scores
                pass_fds=(child.fileno(), line.fileno()),
                start_new_session=True,  # Ctrl-C reaches this process only
            )
        try:
            asked = _Process(name, process, parent)
            is_hidden = asked.ask("import", sys.path, [*hidden], (folder, name)).get("is_hidden")
            yield asked.estimator, is_hidden is True
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, SIGKILL)
            process.wait()


class _Process:
    """A process that serves an estimator."""

    def __init__(self, name: str, process: "subprocess.Popen[bytes]", connection: Connection):
        self._name, self._process, self._connection = name, process, connection

    def estimator(self, task: Question, train: Sequence[Recorded]) -> Predict:
        """The estimator."""
        self.ask(task.name, (task, train))

        def predict(inputs: Array) -> Predicted:
            found = self.ask(task.name, inputs)
            stated = checked(self._name, task, len(inputs), found.get("mean"), found.get("std"))
            return stated.mean if stated.std is None else (stated.mean, stated.std)

        return predict

    def ask(self, where: str, *messages: object) -> Mapping[str, Any]:
        """The answer to messages."""
        try:
            for message in messages:
                self._connection.send(message)
            self._wait(where)
            answer: dict[str, Any] = dict(json.loads(self._connection.recv_bytes(_MOST_BYTES)))
            mistake = InputError(*answer["mistake"]) if "mistake" in answer else None
        except (OSError, EOFError):
            raise _failure(self._name, where, self._end()) from None
        except (ValueError, TypeError, RecursionError):
            raise _failure(self._name, where, "its process answered with something else") from None
        if mistake is not None:
            raise mistake
        return answer

    def _wait(self, where: str) -> None:
        """Waits for an answer, or for the end of the process; what that has started may hold the connection."""
        for waited in count(1):
            has_ended = self._process.poll() is not None
            if self._connection.poll(0.0 if has_ended else 1.0):
                return
            if has_ended:
                raise EOFError
            if waited == _PATIENCE:
                tqdm.write(f"{self._name}: no answer on {where} for {_PATIENCE} s; Ctrl-C ends it", file=sys.stderr)

    def _end(self) -> str:
        try:
            code = self._process.wait(1.0)
        except subprocess.TimeoutExpired:
            return "its process closed the connection"
        return f"its process was ended: {strsignal(-code)}" if code < 0 else f"its process ended with code {code}"


def serve(parent: Connection, line: Connection, is_hidden: bool, folder: str, name: str) -> None:
    """Serves a user's estimator in the process that was started for it, until that is ended or the user's code fails.

    Args:
        parent: pipe for questions and answers.
        line: pipe that the parent closes.
        is_hidden: whether the files of the tasks cannot be read.
        folder: for temporary files; the current folder after the import.
        name: of the estimator.
    """
    begin(line, folder)
    try:
        estimator = OWN.find(name, "estimator", "benchmark")
        os.chdir(folder)
        _answer(parent, is_hidden=is_hidden)
        task, train = parent.recv()
        predict = _called(name, task, estimator, task, train)
        if not callable(predict):
            raise InputError(name, "returned", type(predict).__name__, "must be a function predict(inputs)")
        _answer(parent)
        while True:
            inputs = parent.recv()
            stated = checked(name, task, len(inputs), *mean_and_std(_called(name, task, predict, inputs)))
            _answer(parent, mean=stated.mean.tolist(), std=None if stated.std is None else stated.std.tolist())
    except InputError as error:
        hint = "; folders of recordings cannot be read here" if isinstance(error.__cause__, PermissionError) else ""
        _answer(parent, mistake=[str(error.where), error.field, error.value, error.expected + hint])


def _answer(parent: Connection, **answer: object) -> None:
    parent.send_bytes(json.dumps(answer).encode())


def _called(name: str, task: Question, function: Callable[..., object], *arguments: object) -> object:
    try:
        return function(*arguments)
    except BaseException as error:  # Ctrl-C does not reach this process
        raise _failure(name, task.name, described(error)) from error


def _failure(name: str, where: str, reason: str) -> InputError:
    expected = "must run: estimator(task, train) -> predict, predict(inputs) -> mean or (mean, std)"
    return InputError(name, f"failed on {where}", reason, expected)
