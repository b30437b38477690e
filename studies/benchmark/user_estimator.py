"""Runs a user's estimator in a process of its own, which gets the inputs of the tests alone.

The process has its own memory, a short list of variables, no word of the command line, and, after the import of the
user's module, an empty current folder. With Landlock it cannot open the files of the tasks. Its answers
are JSON, which cannot run code here.
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
from soft_gripper.extras.sweeps.executor import begin
from soft_gripper.registry import OWN
from studies.benchmark.benchmark_task import Estimator, Predict, Predicted, Question, Recorded
from studies.benchmark.estimates import check_estimate, mean_and_std

_SILENT_SECONDS = 60  # s without an answer until a message
_MAX_ANSWER_BYTES = 2**30  # of an answer
_KEPT_VARIABLES = (
    *("HOME", "PATH", "LANG", "LC_ALL", "TMPDIR", "LD_LIBRARY_PATH", "CUDA_VISIBLE_DEVICES"),
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"),
)
_CHILD_SCRIPT = """
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
    environment = {key: os.environ[key] for key in _KEPT_VARIABLES if key in os.environ}
    with TemporaryDirectory(prefix="soft-gripper-", ignore_cleanup_errors=True) as folder, parent, end:
        with child, line:
            process = subprocess.Popen(
                [sys.executable, "-I", "-u", "-c", _CHILD_SCRIPT, str(child.fileno()), str(line.fileno())],
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=2,  # standard output is for the scores
                pass_fds=(child.fileno(), line.fileno()),
                start_new_session=True,  # Ctrl-C reaches this process only
            )
        try:
            server = _Process(name, process, parent)
            is_hidden = server.ask("import", sys.path, [*hidden], (folder, name)).get("is_hidden")
            yield server.estimator, is_hidden is True
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, SIGKILL)
            process.wait()


class _Process:
    """A process that serves an estimator."""

    def __init__(self, name: str, process: "subprocess.Popen[bytes]", connection: Connection):
        self._name, self._process, self._connection = name, process, connection

    def estimator(self, task: Question, train: Sequence[Recorded]) -> Predict:
        """Estimator that asks the process."""
        self.ask(task.name, (task, train))

        def predict(inputs: Array) -> Predicted:
            answer = self.ask(task.name, inputs)
            estimate = check_estimate(self._name, task, len(inputs), answer.get("mean"), answer.get("std"))
            return estimate.mean if estimate.std is None else (estimate.mean, estimate.std)

        return predict

    def ask(self, where: str, *messages: object) -> Mapping[str, Any]:
        """Sends messages, and returns the answer."""
        try:
            for message in messages:
                self._connection.send(message)
            self._wait(where)
            answer: dict[str, Any] = dict(json.loads(self._connection.recv_bytes(_MAX_ANSWER_BYTES)))
            mistake = InputError(*answer["mistake"]) if "mistake" in answer else None
        except (OSError, EOFError):
            raise _failure(self._name, where, self._end()) from None
        except (ValueError, TypeError, RecursionError):
            raise _failure(self._name, where, "its process answered with something else") from None
        if mistake is not None:
            raise mistake
        return answer

    def _wait(self, where: str) -> None:
        """Waits for an answer, or for the end of the process, whose children may hold the connection."""
        for seconds in count(1):
            has_ended = self._process.poll() is not None
            if self._connection.poll(0.0 if has_ended else 1.0):
                return
            if has_ended:
                raise EOFError
            if seconds == _SILENT_SECONDS:
                tqdm.write(
                    f"{self._name}: no answer on {where} for {_SILENT_SECONDS} s; Ctrl-C ends it", file=sys.stderr
                )

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
        predict = _call(name, task, estimator, task, train)
        if not callable(predict):
            raise InputError(name, "returned", type(predict).__name__, "must be a function predict(inputs)")
        _answer(parent)
        while True:
            inputs = parent.recv()
            estimate = check_estimate(name, task, len(inputs), *mean_and_std(_call(name, task, predict, inputs)))
            _answer(parent, mean=estimate.mean.tolist(), std=None if estimate.std is None else estimate.std.tolist())
    except InputError as error:
        hint = "; folders of recordings cannot be read here" if isinstance(error.__cause__, PermissionError) else ""
        _answer(parent, mistake=[str(error.where), error.field, error.value, error.expected + hint])


def _answer(parent: Connection, **answer: object) -> None:
    parent.send_bytes(json.dumps(answer).encode())


def _call(name: str, task: Question, function: Callable[..., object], *arguments: object) -> object:
    try:
        return function(*arguments)
    except BaseException as error:  # Ctrl-C does not reach this process
        raise _failure(name, task.name, described(error)) from error


def _failure(name: str, where: str, reason: str) -> InputError:
    expected = "must run: estimator(task, train) -> predict, predict(inputs) -> mean or (mean, std)"
    return InputError(name, f"failed on {where}", reason, expected)
