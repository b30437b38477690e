"""Calls spread over processes: what they report on the way, what comes of them, and Ctrl-C."""

import logging
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import active_children, get_context
from multiprocessing.queues import Queue
from typing import Any

Call = tuple[Any, ...]
_reports: "Queue[Any]"  # of a worker, to the parent


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
    context = get_context("spawn")
    reports: Queue[Any] = context.Queue()
    with ProcessPoolExecutor(jobs, context, _begin_worker, (reports,)) as pool:
        # Workers start with Ctrl-C ignored, which is for the parent to handle.
        handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
        call_of = {pool.submit(work, *call): call for call in calls}
        signal.signal(signal.SIGINT, handler)
        pending = set(call_of)
        try:
            while pending:
                done, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
                for future in done:
                    ended(call_of[future], future)
                _drain(reports, receive)
        except BaseException:
            for worker in active_children():
                worker.terminate()
                worker.join()
            raise
    _drain(reports, receive)


def _drain(reports: "Queue[Any]", receive: Callable[[Any], Any]) -> None:
    while not reports.empty():
        receive(reports.get())


def report(message: Any) -> None:
    """Reports something to the parent of this process."""
    _reports.put(message)


def _begin_worker(reports: "Queue[Any]") -> None:
    """Keeps the queue to the parent, and ignores Ctrl-C."""
    global _reports
    _reports = reports
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("drake").setLevel(logging.WARNING)  # nobody is to open these Meshcats
