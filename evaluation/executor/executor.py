"""The executor that calls are given to: processes of this machine, or a Dask cluster."""

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from contextlib import contextmanager
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.evaluation.executor.cluster import cluster_executor
from soft_gripper.evaluation.executor.worker_processes import UnguardedScriptError, WorkerProcesses
from soft_gripper.numbers_check import mistyped

Call = tuple[Any, ...]


@contextmanager
def open_executor(jobs: int | None = None, scheduler: str | None = None) -> Iterator[Executor]:
    """An executor, to be used in a `with` of the main thread.

    Args:
        jobs: number of processes of this machine; None: one a core.
        scheduler: address of a Dask scheduler, whose workers are used instead.

    Raises:
        InputError: if the number is none of processes, there is no such scheduler, or Dask is not installed.
    """
    if jobs is not None and (mistyped(int, jobs) or jobs < 1):
        raise InputError("open_executor", "jobs", jobs, "give a whole number of processes, 1 or more")
    opened = WorkerProcesses(jobs or os.cpu_count() or 1) if scheduler is None else cluster_executor(scheduler)
    with opened as executor:
        yield executor


def make_calls(
    executor: Executor,
    work: Callable[..., Any],
    calls: Sequence[Call],
    ended: Callable[[Call, Future[Any]], None],
) -> None:
    """Makes all calls of `work`, and returns when the last has ended.

    Args:
        executor: makes them.
        work: a function of a module, that takes and returns plain data.
        calls: the arguments of each call.
        ended: called here, as each call ends, with its arguments and what came of it; an exception of a call is its to
            find.

    Raises:
        UnguardedScriptError: if the script that this process runs would be run again by every other.
    """
    call_of = {executor.submit(work, *call): call for call in calls}
    for future in as_completed(call_of):
        if isinstance(future.exception(), UnguardedScriptError):
            future.result()
        ended(call_of.pop(future), future)
