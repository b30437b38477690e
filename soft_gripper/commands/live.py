"""soft-gripper live: readings of hardware in, estimates and commands out, in real time."""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.commands.changes import changes_line
from soft_gripper.commands.chosen_station import chosen_scenario
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_folder, check_file, keep_inputs
from soft_gripper.hardware.live.bench import Bench, bench_scenario
from soft_gripper.hardware.live.bench_schema import BenchConfig, described, load_bench
from soft_gripper.hardware.live.endpoints import Endpoints, Sink, Source
from soft_gripper.hardware.live.session import Session
from soft_gripper.hardware.live.twin import Twin, TwinSource
from soft_gripper.hardware.tables import Columns
from soft_gripper.interrupts import held_back
from soft_gripper.scenario.schema import Scenario


class _Live(NamedTuple):
    bench: Bench
    config: BenchConfig
    source: Source
    sink: Sink


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    if options.mcap is not None:
        check_file(options.mcap)
    scenario = bench_scenario(chosen_scenario(options))
    file = options.bench or (None if scenario.bench is None else Path(scenario.bench))
    with Endpoints(file or options.scenario) as endpoints, held_back() as is_interrupted:
        if file is None:
            live = _with_twin(scenario, endpoints, options)
        else:
            live = _with_hardware(scenario, file, endpoints, options)
        _run(Session(*live, is_live=not options.fast), options, is_interrupted)
    for line in _followed(live.bench):
        print(line, file=sys.stderr)
    if options.out is not None:
        with atomic_folder(options.out) as partial:
            live.bench.recording().save(partial / "recording.nc")
        print(f"Recording: {options.out / 'recording.nc'}", file=sys.stderr)
    if options.mcap is not None:
        live.bench.recording().save(options.mcap)
        print(f"Recording: {options.mcap}", file=sys.stderr)


def _with_hardware(scenario: Scenario, file: Path, endpoints: Endpoints, options: argparse.Namespace) -> _Live:
    found = load_bench(file)
    config = replace(found, source=options.source or found.source, sink=options.sink or found.sink)
    moving = [name for name, finger in config.fingers.items() if finger.base_pose is not None]
    bench = Bench(scenario, moving, records=_records(options))
    check_inputs(file, config, bench)
    columns = None if config.time is None else Columns(config.names, config.time)
    if options.mcap is not None:
        keep_inputs([file, config.source.removeprefix("file:")], [options.mcap])
    source = endpoints.source(config.source, 0.0 if options.fast else bench.period, columns)
    return _Live(bench, config, source, endpoints.sink(config.sink or "stdio:"))


def _with_twin(scenario: Scenario, endpoints: Endpoints, options: argparse.Namespace) -> _Live:
    """The scenario names no hardware: its simulated twin stands in for it."""
    twin, sink = Twin(scenario), endpoints.sink(options.sink or "stdio:")
    bench = Bench(scenario, twin.moving, records=_records(options))

    def command(message: bytes, results: dict[str, Any]) -> None:
        twin.command(results)
        sink(message, results)

    return _Live(bench, described(bench.inputs, "twin"), TwinSource(twin), command)


def _followed(bench: Bench) -> Iterator[str]:
    """How far every finger that `recursive` estimates has moved since its calibration."""
    for finger in bench.quantities:
        if f"{finger}.bend_change" in bench.signals:
            yield changes_line(finger, lambda name: bench.read([name])[name])


def _records(options: argparse.Namespace) -> bool:
    return options.out is not None or options.mcap is not None


def check_inputs(file: Path, config: BenchConfig, bench: Bench) -> None:
    """Checks that the bench that a file describes measures all that its estimators need.

    Raises:
        InputError: if it does not.
    """
    found = {
        f"{name}.{kind}": len(fields)
        for name, finger in config.fingers.items()
        for kind, fields in (
            ("pressure", finger.pressures),
            ("tension", finger.tensions),
            ("X_WB", finger.base_pose or []),
        )
    }
    found |= {
        bench.quantities[name]: len(finger.readings)
        for name, finger in config.fingers.items()
        if name in bench.quantities
    }
    unknown = config.fingers.keys() - bench.quantities.keys()
    if unknown:
        raise InputError(file, "fingers", sorted(unknown), f"the scenario has: {', '.join(bench.quantities)}")
    for name, size in bench.inputs.items():
        given = int(config.opening is not None) if name == "grip.set_point" else found.get(name, 0)
        if given != size:
            raise InputError(file, name, f"{given} fields", f"must be {size}")
    names = [name for name in config.send or () if name not in bench.signals]
    if names:
        raise InputError(file, "send", names, f"known signals: {', '.join(bench.signals)}")


def _run(session: Session, options: argparse.Namespace, is_interrupted: Callable[[], bool]) -> None:
    end = time.monotonic() + options.zero
    if options.zero:
        session.zero()
        session.run(lambda: is_interrupted() or time.monotonic() >= end)
        session.zeroed()
    end = time.monotonic() + (np.inf if options.seconds is None else options.seconds)
    session.run(lambda: is_interrupted() or time.monotonic() >= end)
    print(f"Readings: {session.counts}.", file=sys.stderr)
    if session.latencies:
        middle, most = np.percentile(1e3 * np.array(session.latencies), [50, 99])
        print(f"From a reading to its result: {middle:.2f} ms in the median, {most:.2f} ms at 99 %.", file=sys.stderr)
