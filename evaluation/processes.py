"""Calls spread over processes: what they report on the way, what comes of them, and Ctrl-C."""

import logging
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import active_children, get_context
from multiprocessing.queues import Queue
from typing import Any

Call = tuple[Any, ...]
_reports: "Queue[Any] | None"  # of a worker, to the parent


def call_in_processes(
    work: Callable[..., Any],
    calls: Sequence[Call],
    jobs: int,
    ended: Callable[[Call, Future[Any]], None],
    receive: Callable[[Any], Any] = lambda report: None,
) -> None:
    """Makes all calls of `work`, a function of a module, in `jobs` processes, and returns when the last has ended.

    An exception here, Ctrl-C above all, ends the processes at once. One in a call is `ended`'s to find.

    Args:
        work: may `report` to the parent how it gets on.
        calls: the arguments of each call.
        jobs: number of processes.
        ended: called here, as each call ends, with its arguments and what came of it.
        receive: called here with every report.
    """
    reports: Queue[Any] = get_context("spawn").Queue()
    with worker_processes(jobs, reports) as pool:
        call_of = {submit_quietly(pool, work, *call): call for call in calls}
        pending = set(call_of)
        while pending:
            done, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
            for future in done:
                ended(call_of[future], future)
            _drain(reports, receive)
    _drain(reports, receive)


@contextmanager
def worker_processes(jobs: int, reports: "Queue[Any] | None" = None) -> Iterator[ProcessPoolExecutor]:
    """Processes that an exception here, Ctrl-C above all, ends at once; `reports` is where theirs go."""
    with ProcessPoolExecutor(jobs, get_context("spawn"), _begin_worker, (reports,)) as pool:
        try:
            yield pool
        except BaseException:
            for worker in active_children():
                worker.terminate()
                worker.join()
            raise


def submit_quietly(pool: ProcessPoolExecutor, work: Callable[..., Any], *call: Any) -> "Future[Any]":
    """Submits a call; a worker that this starts leaves Ctrl-C to the parent."""
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        return pool.submit(work, *call)
    finally:
        signal.signal(signal.SIGINT, handler)


def _drain(reports: "Queue[Any]", receive: Callable[[Any], Any]) -> None:
    while not reports.empty():
        receive(reports.get())


def report(message: Any) -> None:
    """Reports something to the parent of this process."""
    assert _reports is not None
    _reports.put(message)


def _begin_worker(reports: "Queue[Any] | None") -> None:
    """Keeps the queue to the parent, and ignores Ctrl-C."""
    global _reports
    _reports = reports
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("drake").setLevel(logging.WARNING)  # nobody is to open these Meshcats
