"""A Dask cluster as an executor; see docs/cluster.md."""

import logging
import socket
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from soft_gripper.errors import InputError

WAIT = 10  # s, for the scheduler to answer


@contextmanager
def cluster_executor(scheduler: str) -> Iterator[Executor]:
    """The workers of a scheduler; a call whose worker dies is made again by another.

    Args:
        scheduler: address, such as "tcp://127.0.0.1:8786".

    Raises:
        InputError: if no scheduler answers there, its workers are not fit, or Dask is not installed.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        raise InputError("executor", "--scheduler", scheduler, "pip install 'soft-gripper[cluster]'") from None
    logging.getLogger("distributed").setLevel(logging.CRITICAL)  # a mistake is reported in one line, below
    try:
        # Before there is a Client, which would go on trying for long after it has failed.
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
        with client.get_executor() as executor:
            yield executor
