"""Calls spread over processes: what they tell on the way, what comes of them, and Ctrl-C."""

import logging
import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from multiprocessing import active_children, get_context
from multiprocessing.queues import Queue
from typing import Any

Call = tuple[Any, ...]
_told: "Queue[Any]"  # of a worker: where it tells the parent


def call_in_processes(
    work: Callable[..., Any],
    calls: Sequence[Call],
    jobs: int,
    ended: Callable[[Call, Future[Any]], None],
    hear: Callable[[Any], Any] = lambda news: None,
) -> None:
    """Makes all calls of `work`, a function of a module, in `jobs` processes, and returns when the last has ended.

    An exception here, Ctrl-C above all, ends the processes at once. One in a call is `ended`'s to find.

    Args:
        work: may `tell` the parent how it gets on.
        calls: the arguments of each call.
        jobs: number of processes.
        ended: called here, as each call ends, with its arguments and what came of it.
        hear: called here with what is told.
    """
    context = get_context("spawn")
    told: Queue[Any] = context.Queue()
    with ProcessPoolExecutor(jobs, context, _begin_worker, (told,)) as pool:
        # Workers are born deaf to Ctrl-C, which is for the parent to handle.
        hearing = signal.signal(signal.SIGINT, signal.SIG_IGN)
        call_of = {pool.submit(work, *call): call for call in calls}
        signal.signal(signal.SIGINT, hearing)
        pending = set(call_of)
        try:
            while pending:
                done, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
                for future in done:
                    ended(call_of[future], future)
                _hear_all(told, hear)
        except BaseException:
            for worker in active_children():
                worker.terminate()
                worker.join()
            raise
    _hear_all(told, hear)


def _hear_all(told: "Queue[Any]", hear: Callable[[Any], Any]) -> None:
    while not told.empty():
        hear(told.get())


def tell(news: Any) -> None:
    """Tells the parent of this process something."""
    _told.put(news)


def _begin_worker(told: "Queue[Any]") -> None:
    """Keeps the way to the parent, and stays deaf to Ctrl-C."""
    global _told
    _told = told
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.getLogger("drake").setLevel(logging.WARNING)  # nobody is to open these Meshcats
