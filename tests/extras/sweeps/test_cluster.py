"""A Dask cluster: a scheduler and two workers, each a process of its own, on this machine."""

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import short, soft_gripper
from refusals import refused
from waiting import wait_until

from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.study import run_study

Client = pytest.importorskip("distributed", reason="Dask is not installed: pip install 'soft-gripper[cluster]'").Client

SWEEP = ["sweep", "free_bending", *short("pressure.settle=0.1"), "--vary", "sensor.sections=1,2,3,4,6,12"]


def square_slowly(number: int) -> int:
    time.sleep(0.2)
    return number**2


def free_port() -> int:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        return int(listening.getsockname()[1])


def dask(kind: str, *arguments: object) -> "subprocess.Popen[bytes]":
    module = f"distributed.cli.dask_{kind}"
    command = [sys.executable, "-m", module, *map(str, arguments), "--no-dashboard"]
    knows = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}  # the functions of this file
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen(command, env=knows, start_new_session=True, **quiet)


def worker(address: str, threads: int = 1) -> "subprocess.Popen[bytes]":
    """One process: a nanny would start the worker again."""
    return dask("worker", address, "--nthreads", threads, "--no-nanny")


def answers(port: int) -> bool:
    """Whether somebody listens."""
    with socket.socket() as asking:
        return asking.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    """A scheduler; tests start its workers."""
    port = free_port()
    with dask("scheduler", "--host", "127.0.0.1", "--port", port) as process:
        wait_until(lambda: answers(port))
        yield f"tcp://127.0.0.1:{port}"
        process.kill()


@pytest.fixture
def workers(address: str) -> Iterator["list[subprocess.Popen[bytes]]"]:
    started = [worker(address), worker(address)]
    yield started
    for process in started:
        process.kill()
        process.wait()
    with Client(address, set_as_default=False) as client:  # the scheduler notices a moment later
        wait_until(lambda: not client.scheduler_info()["workers"])


@pytest.mark.slow
def test_a_sweep_is_the_same_as_in_processes_here(address, workers, tmp_path):
    here, there = tmp_path / "here", tmp_path / "there"
    assert soft_gripper(*SWEEP, "--jobs", 2, "--out", here).code == 0
    assert soft_gripper(*SWEEP, "--scheduler", address, "--out", there).code == 0
    assert (here / "sweep.csv").read_bytes() == (there / "sweep.csv").read_bytes()


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_no_call(address, workers):
    found: dict[int, int] = {}

    def keep(number, square):
        found[number] = square
        if len(found) == 5:
            workers[0].send_signal(signal.SIGKILL)

    with open_executor(scheduler=address) as executor:
        run_study(executor, square_slowly, {i: (i,) for i in range(30)}, keep)
    assert found == {i: i**2 for i in range(30)}
    assert workers[0].wait() == -signal.SIGKILL


@pytest.mark.slow
def test_workers_of_several_threads_are_refused(address):
    process = worker(address, threads=2)
    try:
        with refused("--scheduler"):
            look_for_it(address)
    finally:
        process.kill()
        process.wait()


def look_for_it(address: str) -> None:
    for _ in range(100):
        with open_executor(scheduler=address):
            time.sleep(0.2)  # until the worker is there


@pytest.mark.parametrize("scheduler", ["tcp://127.0.0.1:{port}", "nonsense"])
def test_a_scheduler_that_is_not_there_is_reported_in_a_line(scheduler, tmp_path):
    begun = time.monotonic()
    done = soft_gripper(*SWEEP, "--scheduler", scheduler.format(port=free_port()), "--out", tmp_path / "out")
    assert done.code == 2
    assert "no Dask scheduler answers there" in done.err
    assert done.err.count("\n") == 1
    assert time.monotonic() - begun < 15
    assert not Path(tmp_path / "out").exists()
