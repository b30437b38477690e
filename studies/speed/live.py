"""Sends readings over UDP for minutes: latency, losses and memory of `soft-gripper live`.

`soft-gripper live` runs as a process of its own, at 100 Hz. Measured from outside are the readings without a result
that are not counted as lost, the time from sending a reading to receiving its result, and the memory at the end, less
that after a tenth of the time. The command itself prints the processor time that it needs from a reading to its
result, which does not suffer from other processes as time does.
"""

import argparse
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any, NamedTuple

import numpy as np
import yaml

import soft_gripper as sg
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.messages import encoded
from soft_gripper.extras.hardware.bench_schema import bench_from_inputs

SCENARIO, PERIOD = "tip_distance_steps", 0.01
LOOPBACK, START = "127.0.0.1", 60.0  # s that the command may take until it listens
COMMAND = [
    sys.executable,
    "-c",
    "import sys; from soft_gripper.commands import main; sys.exit(main())",
    "live",
    SCENARIO,
]


class LiveMeasurements(NamedTuple):
    """Measurements of one run."""

    unreported: int  # readings without result, and not counted as lost
    latency: np.ndarray  # s, of those with one
    grown: float  # MB
    said: str  # by the command


def recorded_messages(changes: list[str]) -> list[dict[str, Any]]:
    """Readings and pressures of a simulated run, a message for each sample."""
    scenario = sg.load_scenario(SCENARIO, changes)
    recording, bench = sg.simulate(scenario), Bench(scenario)
    signals = {name: name.replace(".pressure", ".sampled_pressure") for name in bench.inputs}
    rows = range(1, recording.data.sizes["time"])
    return [{name: np.ravel(recording[signal_name].values[i]) for name, signal_name in signals.items()} for i in rows]


def write_bench(file: Path, sizes: Mapping[str, int], ports: tuple[int, int]) -> None:
    """Writes the description of the hardware that this script stands for."""
    config = bench_from_inputs(sizes, f"udp://:{ports[0]}")
    fingers = {n: {"readings": f.readings, "pressures": f.pressures} for n, f in config.fingers.items()}
    text = {"source": config.source, "sink": f"udp://:{ports[1]}", "count": "count", "time": "time", "fingers": fingers}
    file.write_text(yaml.safe_dump(text), encoding="utf-8")


def resident_memory(process: int) -> float:
    """Memory of a process, MB."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def receive_results(socket_: socket.socket, arrival_times: dict[int, float]) -> None:
    """Notes the arrival, s, of the first result of each reading, until a timeout."""
    while True:
        try:
            result = json.loads(socket_.recv(2**16))
        except TimeoutError:
            return
        if result.get("age") == 0 and result["count"] is not None:
            arrival_times.setdefault(int(result["count"]), time.monotonic())


def measure(seconds: float, changes: list[str], options: list[str]) -> LiveMeasurements:
    """Sends readings for some time, s, and measures the results."""
    messages = recorded_messages(changes)
    with TemporaryDirectory() as folder, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
        link.bind((LOOPBACK, 0))
        link.settimeout(3.0)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free_socket:
            free_socket.bind((LOOPBACK, 0))
            port = free_socket.getsockname()[1]
        bench = Path(folder) / "bench.yaml"
        write_bench(bench, {name: len(value) for name, value in messages[0].items()}, (port, link.getsockname()[1]))
        set_options = [part for change in changes for part in ("--set", change)]
        command = [*COMMAND, "--bench", str(bench), *set_options, *options]
        with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=folder) as process:
            link.settimeout(START)
            link.recv(2**16)  # that no reading has arrived yet
            link.settimeout(3.0)
            arrivals: dict[int, float] = {}
            listener = Thread(target=receive_results, args=(link, arrivals))
            listener.start()
            sent, sizes = send(link, port, messages, seconds, process.pid)
            time.sleep(1.0)
            process.send_signal(signal.SIGINT)
            assert process.stderr is not None
            output = process.stderr.read()
        listener.join()
    lost_count = int(re.findall(r"(\d+) lost", output)[0])
    latency = np.array([arrivals[count] - time_sent for count, time_sent in sent.items() if count in arrivals])
    return LiveMeasurements(len(sent) - len(latency) - lost_count, latency, sizes[-1] - sizes[0], output)


def send(
    link: socket.socket, port: int, messages: list[dict[str, Any]], seconds: float, process: int
) -> tuple[dict[int, float], list[float]]:
    """Sends readings; returns their times, s, and the memory of the process after a tenth and at the end, MB."""
    sent, sizes, begin, number = {}, [], time.monotonic(), round(seconds / PERIOD)
    for i in range(number):
        message = encoded({"count": float(i), "time": PERIOD * i, **messages[i % len(messages)]}, "json")
        time.sleep(max(0.0, begin + PERIOD * i - time.monotonic()))
        sent[i] = time.monotonic()
        link.sendto(message, (LOOPBACK, port))
        if i in (number // 10, number - 1):
            sizes.append(resident_memory(process))
    return sent, sizes


def run(options: argparse.Namespace) -> int:
    """Prints the measurements; exit code 1: a reading was lost and not reported, or memory grew by more than 5 MB."""
    changes = [f"estimator.type={options.estimator}"]
    result = measure(options.seconds, changes, ["--page"] if options.page else [])
    print(result.said.strip())
    middle, high = 1e3 * np.percentile(result.latency, [50, 99])
    print(f"From sending a reading to receiving its result: {middle:.2f} ms in the median, {high:.2f} ms at 99 %.")
    print(f"Readings lost and not reported: {result.unreported}. Memory: {result.grown:+.1f} MB.")
    return int(result.unreported != 0 or result.grown > 5.0)
