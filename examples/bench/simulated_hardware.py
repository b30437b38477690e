"""Plays the hardware of a bench: simulates a gripper, sends readings and obeys commands, as a microcontroller does.

It speaks JSON over UDP to `soft-gripper live`, or over a pseudo-terminal that looks like a serial port:

    python examples/bench/simulated_hardware.py examples/bench/held_cup.yaml
    soft-gripper live examples/bench/held_cup.yaml --bench examples/bench/held_cup_bench.yaml

    python examples/bench/simulated_hardware.py examples/bench/held_cup.yaml --pty
    soft-gripper live examples/bench/held_cup.yaml --bench examples/bench/held_cup_bench.yaml \\
      --source serial:///dev/pts/3 --sink serial:///dev/pts/3
"""

import argparse
import os
import signal
import time
import tty
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import advance, make_simulator
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.bench.endpoints import Endpoints, LineSource, Sink, Source, writer
from soft_gripper.extras.bench.messages import MalformedError, decoded, encoded
from soft_gripper.extras.bench.threads import Message
from soft_gripper.interrupts import held_back
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import EstimatorConfig, Scenario
from soft_gripper.scenario.sensor_presets import sensor_layout

_LOG_SAMPLES = 100  # samples after which the logs are cleared


class SimulatedHardware:
    """A station that is advanced by a period of its sensors at a time, and commanded from outside.

    Its messages name the inputs of a `Bench` of the same scenario, `{finger}.strain`, and `count` and `time`.
    """

    def __init__(self, scenario: Scenario, records: bool = False):
        """
        Args:
            scenario: its fingers are commanded by `command`; a task may move its arm, but not the gripper.
            records: whether every signal is kept for `station.recording`, which takes memory.
        """
        self.station = make_station(hardware_scenario(scenario))
        self._records = records
        self.period = scenario.sensor.period
        self._samples = 0
        self._simulator = make_simulator(self.station)
        self.context: Context = self._simulator.get_mutable_context()
        inputs = self.station.parts.inputs
        self._inputs = {name: self.station.diagram.GetInputPort(name) for name in inputs}
        for port in self._inputs.values():
            port.FixValue(self.context, np.zeros(port.size()))
        self._signals: dict[str, str] = {}
        for finger in self.station.fingers:
            quantity = sensor_layout(finger.finger, scenario.sensor).quantity
            sent = {quantity: quantity, "pressure": "sampled_pressure", "tension": "sampled_tension"}
            sent |= {"X_WB": "X_WB"} if finger.name in self.moving else {}
            sources = {f"{finger.name}.{kind}": f"{finger.name}.{signal}" for kind, signal in sent.items()}
            self._signals |= {name: signal for name, signal in sources.items() if signal in self.station.parts.signals}

    @property
    def moving(self) -> list[str]:
        """Names of the fingers with a moving base, which is measured."""
        return [finger.name for finger in self.station.fingers if not finger.is_anchored]

    def message(self) -> dict[str, Any]:
        """Readings of the sensors after the next period, as a message."""
        self._samples += 1
        advance(self._simulator, self.station, self._samples * self.period)
        if not self._records and self._samples % _LOG_SAMPLES == 0:
            self.station.logs.clear(self.context)
        read = self.read([*self._signals.values()])
        sent = {name: read[signal] for name, signal in self._signals.items()}
        return {"count": float(self._samples), "time": self.context.get_time(), **sent}

    def read(self, signals: Sequence[str]) -> dict[str, Array]:
        """Reads signals of the station at the last sample, (size,) each."""
        return {name: self.station.diagram.GetOutputPort(name).Eval(self.context) for name in signals}

    def command(self, commands: Mapping[str, Any]) -> None:
        """Obeys a result of a bench, as far as it has commands: vectors, or entries `{name}[i]`."""
        for name, port in self._inputs.items():
            entries = [commands.get(f"{name}[{i}]") for i in range(port.size())]
            given = commands.get(name, None if None in entries else entries)
            if given is not None and np.isfinite(given).all():
                port.FixValue(self.context, np.ravel(given))


def hardware_scenario(scenario: Scenario) -> Scenario:
    """A scenario reduced to its hardware: external commands, default estimator, no grip control."""
    control = replace(scenario.control, set_points=None, force_limit=None)
    return replace(scenario, control=control, external=["pressure"], estimator=EstimatorConfig())


def run_hardware(hardware: SimulatedHardware, source: Source, sink: Sink, is_over: Callable[[], bool]) -> None:
    """Sends readings and obeys commands in real time."""
    began = time.monotonic()
    for sample in range(1, 10**9):
        if is_over():
            return
        message = hardware.message()
        for command in source.receive(max(0.0, began + sample * hardware.period - time.monotonic())):
            _obey(hardware, command)
        time.sleep(max(0.0, began + sample * hardware.period - time.monotonic()))
        sink(encoded(message, "json"), message)


def _obey(hardware: SimulatedHardware, command: Message) -> None:
    with suppress(MalformedError):  # hardware obeys what it understands
        hardware.command(command if isinstance(command, dict) else decoded(command, "json", ()))


def _main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", help="name or file of a scenario")
    parser.add_argument("--set", action="append", default=[], metavar="FIELD=VALUE", help="change the scenario")
    parser.add_argument("--source", default="udp://:5006", help="address where commands arrive")
    parser.add_argument("--sink", default="udp://:5005", help="address that readings are sent to")
    parser.add_argument("--pty", action="store_true", help="speak over a pseudo-terminal instead, and print its name")
    parser.add_argument("--out", type=Path, metavar="FILE", help="file for a recording of every signal, .nc")
    options = parser.parse_args()
    hardware = SimulatedHardware(load_scenario(options.scenario, options.set), records=options.out is not None)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # it is held back, too
    with Endpoints("simulated_hardware") as endpoints, held_back() as is_over:
        if options.pty:
            ours, theirs = os.openpty()
            tty.setraw(theirs)
            os.set_blocking(ours, False)
            print(os.ttyname(theirs), flush=True)
            run_hardware(hardware, LineSource(ours), writer(ours), is_over)
        else:
            run_hardware(hardware, endpoints.source(options.source), endpoints.sink(options.sink), is_over)
    if options.out is not None:
        hardware.station.recording(hardware.context).save(options.out)


if __name__ == "__main__":
    _main()
