"""The executor that runs calls: processes on this machine, or a Dask cluster.

WorkerProcesses is an executor whose processes are replaced when they have grown or died.

Drake 1.51 does not free systems written in Python along with their diagram, so every station built stays in memory,
8 to 20 MB; Drake 1.58 does. A process that has grown by GROWTH is replaced; the next one has to fill its caches anew.
"""

import logging
import os
import pickle
import reprlib
import resource
import shutil
import signal
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from functools import partial
from multiprocessing import forkserver, get_context
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.spawn import get_preparation_data
from pathlib import Path
from threading import Thread
from types import TracebackType
from typing import Any, NamedTuple

from soft_gripper.child_processes import SAFE_PATH, environment
from soft_gripper.errors import InputError, WorkerDiedError, first_line
from soft_gripper.library_messages import printed_as_notes

WAIT = 10  # s, for the scheduler to answer


@contextmanager
def cluster_executor(scheduler: str) -> Iterator[Executor]:
    """The workers of a scheduler; if a worker dies, another repeats its call.

    Args:
        scheduler: its address, such as "tcp://127.0.0.1:8786".

    Raises:
        InputError: if no scheduler answers there, its workers are unsuitable, or Dask is not installed.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError("executor", "--scheduler", scheduler, "pip install 'soft-gripper[cluster]'") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # errors are reported in one line, below
    try:
        # Before creating a Client, which would keep trying long after it has failed.
        socket.create_connection(get_address_host_port(scheduler, strict=True), WAIT).close()
        client = Client(scheduler, timeout=WAIT, set_as_default=False)
    except (OSError, ValueError, TypeError, MemoryError) as error:
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError("executor", "--scheduler", scheduler, f"no Dask scheduler answers there: {reason}") from None
    with client:
        for address, worker in client.scheduler_info(n_workers=-1)["workers"].items():
            if worker["nthreads"] > 1:
                expected = f"its worker {address} has {worker['nthreads']} threads; start workers with --nthreads 1"
                raise InputError("executor", "--scheduler", scheduler, expected)
        yield _ClusterExecutor(client)


class _ClusterExecutor(Executor):
    """Calls by the workers of a Dask client.

    The client's own executor fails where a worker dies just after it has returned its result: that call is then both
    finished and waiting for another worker (distributed, `_cascade_future`). `Future.result` waits for that worker.
    """

    def __init__(self, client: Any):
        self._client = client

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **named: Any) -> "Future[Any]":
        """Makes a call in one of the workers; see Executor."""
        assert not named
        future: Future[Any] = Future()
        self._client.submit(work, *arguments).add_done_callback(partial(_copy_outcome, future))
        return future


def _copy_outcome(future: "Future[Any]", remote: Any) -> None:
    try:
        future.set_result(remote.result())
    except BaseException as error:
        future.set_exception(error)


_MEMORY_UNIT = 1 if sys.platform == "darwin" else 1024  # bytes per unit that the system reports


class FinishedCall(NamedTuple):
    """Result of a call, and the memory of its process."""

    result: Any
    memory: int  # peak resident size of the process, bytes


def begin(line: Connection, folder: str) -> None:
    """Prepares a worker process.

    Args:
        line: pipe from the parent that carries no data; the process ends when the parent closes it or dies.
        folder: folder for temporary files.
    """
    tempfile.tempdir = folder
    logging.getLogger("drake").setLevel(logging.WARNING)  # suppress the "Meshcat listening" messages
    Thread(target=_end_with, args=(line, folder), daemon=True).start()


def _end_with(line: Connection, folder: str) -> None:
    line.poll(None)  # until the other end is closed
    shutil.rmtree(folder, ignore_errors=True)
    os._exit(1)


def make(name: str, call: bytes) -> FinishedCall:
    """Makes a call, a pickled function and its arguments; warnings of libraries are printed as notes, as in the parent.

    Raises:
        MainScriptError: naming the call, if this process cannot import its parts.
    """
    with printed_as_notes():
        try:
            work, arguments = pickle.loads(call)
        except (AttributeError, ImportError) as error:
            rule = "import it from a module; processes do not see a notebook, an interactive session or `python -c`"
            raise MainScriptError("script", "__main__", name, f"{rule}: {first_line(error)}") from None
        result = work(*arguments)
    return FinishedCall(result, _MEMORY_UNIT * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


GROWTH = 300 * 2**20  # bytes by which a process may grow after its first call before it is replaced
ATTEMPTS = 2  # at a call, if its process dies
# Modules that most calls need, imported once by the server from which processes are forked, so that another process
# takes only a tenth of a second; xarray loads dask.array on first use, if installed.
_PRELOADED_MODULES = ("soft_gripper.extras.sweeps.server_folder", "soft_gripper.extras.sweeps.sweep", "dask.array")
_SERVER_CONTEXT = get_context("forkserver")
_EXIT_TIMEOUT = 5.0  # s, to wait for a dead process to disappear
_MAX_PATH_LENGTH = 70  # bytes in the path of the temporary folder; paths of its sockets are limited to 107
_UNGUARDED_EXIT_CODE = 79  # exit code of a process whose script opens an executor when imported
_THREADS_VARIABLE = "OPENBLAS_NUM_THREADS"
_LOGGER = logging.getLogger(__name__)


class MainScriptError(InputError):
    """The main script, which every process imports, cannot be used by processes."""


def _script_error(mend: str) -> MainScriptError:
    script = getattr(sys.modules["__main__"], "__file__", None)
    return MainScriptError("script", "__main__", script, f"every process imports it: {mend}")


class WorkerProcesses(Executor):
    """A number of processes, each with one call at a time; create it in the main thread, and use it in a `with`.

    Each process is in a pool of its own, so that its death affects no other call. Its call is repeated in another
    process, and fails with a WorkerDiedError if that dies too. An exception within the `with`, above all Ctrl-C, ends
    the processes at once; so does the death of this process, by any signal.
    """

    def __init__(self, jobs: int):
        """`jobs` is the number of processes.

        Raises:
            InputError: if the path of the temporary folder is too long, or if the main script comes from a pipe.
        """
        temporary = tempfile.gettempdir()
        if len(os.fsencode(temporary)) > _MAX_PATH_LENGTH:
            expected = f"processes communicate by sockets there: give a path of at most {_MAX_PATH_LENGTH} bytes"
            raise InputError("environment", "TMPDIR", temporary, expected)
        _start_server()
        self._folder = tempfile.TemporaryDirectory(prefix="soft-gripper-", ignore_cleanup_errors=True)
        self._threads = ThreadPoolExecutor(jobs)
        self._thread_data = threading.local()
        self._workers: set[_Worker] = set()
        self._is_ended = False

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **named: Any) -> "Future[Any]":
        """Makes a call of a function of a module in one of the processes; see Executor."""
        assert not named
        return self._threads.submit(self._call, work, arguments)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the processes when their calls have finished; see Executor."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        for worker in set(self._workers):
            worker.end()
        self._folder.cleanup()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        if kind is not None:
            self._is_ended = True
            for worker in set(self._workers):
                worker.cut()
        self.shutdown(cancel_futures=kind is not None)

    def _call(self, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """The result of a call; runs in a thread with its own process."""
        for attempt in range(1, ATTEMPTS + 1):
            worker = self._worker()
            try:
                return worker.call(work, arguments)
            except BrokenProcessPool:
                if self._is_ended:
                    raise
                self._replace(worker)
                _LOGGER.warning("process %d of %d died at %s", attempt, ATTEMPTS, name_of(work, arguments))
            finally:
                if worker.has_grown:
                    self._replace(worker)
        raise WorkerDiedError(f"the process died {ATTEMPTS} times at {name_of(work, arguments)}: out of memory?")

    def _worker(self) -> "_Worker":
        if self._is_ended:
            raise BrokenProcessPool
        if getattr(self._thread_data, "worker", None) is None:
            self._thread_data.worker = _Worker(self._folder.name)
            self._workers.add(self._thread_data.worker)
        worker: _Worker = self._thread_data.worker
        return worker

    def _replace(self, worker: "_Worker") -> None:
        self._thread_data.worker = None
        self._workers.discard(worker)
        worker.end()


class _Worker:
    """Process that makes one call at a time, and its memory in use."""

    def __init__(self, folder: str):
        end, self._line = _SERVER_CONTEXT.Pipe(duplex=False)
        self._pool = ProcessPoolExecutor(1, _SERVER_CONTEXT, begin, (end, folder))
        self._end = end
        self._memory: int | None = None
        self.has_grown = False

    def call(self, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """Raises BrokenProcessPool if the process dies, MainScriptError if it would run the script again."""
        future = self._pool.submit(make, name_of(work, arguments), pickle.dumps((work, arguments)))
        processes = list(self._pool._processes.values())
        try:
            result = future.result()
        except BrokenProcessPool:
            if any(_exit_code(process) == _UNGUARDED_EXIT_CODE for process in processes):
                raise _script_error('put its statements below `if __name__ == "__main__":`') from None
            raise
        self._memory = result.memory if self._memory is None else self._memory
        self.has_grown = result.memory > self._memory + GROWTH
        return result.result

    def end(self) -> None:
        """Waits for the process to end."""
        self._pool.shutdown()
        self.cut()

    def cut(self) -> None:
        """Ends the process at once."""
        self._line.close()


def name_of(work: Callable[..., Any], arguments: tuple[Any, ...]) -> str:
    """A short description of a call."""
    return f"{getattr(work, '__name__', work)}({', '.join(map(reprlib.repr, arguments))})"


def _exit_code(process: BaseProcess) -> int | None:
    process.join(_EXIT_TIMEOUT)
    return process.exitcode


def _start_server() -> None:
    """Starts the server from which processes are forked; it ignores Ctrl-C and SIGHUP, and so do they.

    A terminal sends both to all processes, and this one ends the others. Python's tracker of resources inherits this:
    without it, another one would be started, and complain of what it does not know.

    Its own imports do not come from the current folder, which Python would search first, and a main script that is a
    pipe is refused before. Products of matrices take one thread, unless the user says otherwise: there is a process for
    every core, and threads that wait for each other take twice the time to judge a run.
    """
    _SERVER_CONTEXT.set_forkserver_preload(list(_PRELOADED_MODULES))
    handlers = {number: signal.signal(number, signal.SIG_IGN) for number in (signal.SIGINT, signal.SIGHUP)}
    try:
        imported = get_preparation_data("").get("init_main_from_path")
        if imported is not None and not Path(imported).is_file():
            raise _script_error('save it as a file, with its statements below `if __name__ == "__main__":`')
        with environment(SAFE_PATH | {_THREADS_VARIABLE: os.environ.get(_THREADS_VARIABLE, "1")}):
            forkserver.ensure_running()
    except RuntimeError:  # raised by a process that has not yet started to work
        os._exit(_UNGUARDED_EXIT_CODE)
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)


@contextmanager
def open_executor(jobs: int | None = None, scheduler: str | None = None) -> Iterator[Executor]:
    """An executor, to be used in a `with` in the main thread.

    Args:
        jobs: number of processes on this machine; None: one per core.
        scheduler: address of a Dask scheduler whose workers are used instead.

    Raises:
        InputError: if the number of processes is invalid, no scheduler answers, or Dask is not installed.
    """
    if jobs is not None and (not isinstance(jobs, int) or isinstance(jobs, bool) or jobs < 1):
        raise InputError("open_executor", "jobs", jobs, "give a whole number of processes, 1 or more")
    new_executor = WorkerProcesses(jobs or os.cpu_count() or 1) if scheduler is None else cluster_executor(scheduler)
    with new_executor as executor:
        yield executor
