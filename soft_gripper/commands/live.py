"""soft-gripper live: readings of hardware in, estimates and commands out, in real time, and a page that shows them."""

import argparse
import logging
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
from soft_gripper.files.output import atomic_folder, check_file, keep_inputs, lock_folder
from soft_gripper.hardware.live.bench import Bench, bench_scenario
from soft_gripper.hardware.live.bench_schema import BenchConfig, described, load_bench
from soft_gripper.hardware.live.endpoints import Endpoints, Sink, Source
from soft_gripper.hardware.live.session import Session
from soft_gripper.hardware.live.twin import Twin, TwinSource
from soft_gripper.hardware.table import Columns
from soft_gripper.interrupts import held_back
from soft_gripper.play.live_view import LiveView
from soft_gripper.play.page_server import LivePage, page_contents, page_server
from soft_gripper.scenario.schema import Scenario


class _Live(NamedTuple):
    bench: Bench
    config: BenchConfig
    source: Source
    sink: Sink
    twin: Twin | None  # shown on the page
    moving: list[str]  # fingers


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    if options.mcap is not None:
        check_file(options.mcap)
    scenario = bench_scenario(chosen_scenario(options))
    file = options.bench or (None if scenario.bench is None else Path(scenario.bench))
    if options.twin and (file is None or not options.page):
        raise InputError("live", "--twin", True, "is shown beside hardware: give --bench and --page")
    if options.mcap is not None and options.page:
        raise InputError("live", "--mcap", str(options.mcap), "records a whole session: leave it, or --page, out")
    with Endpoints(file or options.scenario) as endpoints, held_back() as is_interrupted:
        if file is None:
            live = _with_twin(scenario, endpoints, options)
        else:
            live = _with_hardware(scenario, file, endpoints, options)
        session = Session(live.bench, live.config, live.source, live.sink, is_live=not options.fast)
        if options.page:
            _show(session, live, options, is_interrupted)
        else:
            _run(session, options, is_interrupted)
    for line in _followed(live.bench):
        print(line, file=sys.stderr)
    if not options.page:
        _keep(live.bench, options.out, options.mcap)


def _keep(bench: Bench, out: Path | None, mcap: Path | None) -> None:
    if out is not None:
        with atomic_folder(out) as partial:
            bench.recording().save(partial / "recording.nc")
        print(f"Recording: {out / 'recording.nc'}", file=sys.stderr)
    if mcap is not None:
        bench.recording().save(mcap)
        print(f"Recording: {mcap}", file=sys.stderr)


def _show(session: Session, live: _Live, options: argparse.Namespace, is_interrupted: Callable[[], bool]) -> None:
    """Runs a session with its page."""
    name = Path(options.scenario).stem
    logging.getLogger("drake").setLevel(logging.WARNING)  # suppress the "Meshcat listening" messages
    folder = lock_folder(options.out or Path("results") / "live" / name)
    view = LiveView(session, live.bench, folder, live.moving, live.twin)
    about = page_contents("live", name, live.bench.scenario, view.panel, view.signals, view.owners)
    page, began = LivePage(about, view.panel, view.feed), time.monotonic()

    def between() -> None:
        view.refresh()
        if options.twin and live.twin is not None:
            live.twin.follow(session.results, live.bench, time.monotonic() - began)

    with page_server(options.host, lambda: view.scene, page) as address:
        print(f"Open {address} in a browser. The 'stop' button there, or Ctrl-C here, ends it.", file=sys.stderr)
        if options.out is not None:
            view.recorder.begin()
        try:
            _run(session, options, lambda: view.is_over or is_interrupted(), between)
        finally:
            view.recorder.close()
            if page.refused:
                print(f"Rejected {page.refused} messages that were not valid commands.", file=sys.stderr)
            print("Recordings:", ", ".join(map(str, view.recorder.recordings)) or "none.", file=sys.stderr)


def _with_hardware(scenario: Scenario, file: Path, endpoints: Endpoints, options: argparse.Namespace) -> _Live:
    found = load_bench(file)
    config = replace(found, source=options.source or found.source, sink=options.sink or found.sink)
    moving = [name for name, finger in config.fingers.items() if finger.base_pose is not None]
    bench = Bench(scenario, moving, records=_records(options))
    check_inputs(file, config, bench)
    columns = None if config.time is None else Columns(dict.fromkeys(config.names, "fields"), config.time)
    if options.mcap is not None:
        keep_inputs([file, config.source.removeprefix("file:")], [options.mcap])
    source = endpoints.source(config.source, 0.0 if options.fast else bench.period, columns)
    twin = Twin(scenario) if options.twin else None
    return _Live(bench, config, source, _sink(endpoints, config.sink, options), twin, moving)


def _with_twin(scenario: Scenario, endpoints: Endpoints, options: argparse.Namespace) -> _Live:
    """The scenario names no hardware: its simulated twin stands in for it."""
    twin, sink = Twin(scenario), _sink(endpoints, options.sink, options)
    bench = Bench(scenario, twin.moving, records=_records(options))

    def command(message: bytes, results: dict[str, Any]) -> None:
        twin.command(results)
        sink(message, results)

    return _Live(bench, described(bench.inputs, "twin"), TwinSource(twin), command, twin, twin.moving)


def _sink(endpoints: Endpoints, address: str | None, options: argparse.Namespace) -> Sink:
    """Where results go; without an address to standard output, or to the page alone."""
    if address is None and options.page:
        return lambda *_: None
    return endpoints.sink(address or "stdio:")


def _followed(bench: Bench) -> Iterator[str]:
    """How far every finger that `recursive` estimates has moved since its calibration."""
    for finger in bench.quantities:
        if f"{finger}.bend_change" in bench.signals:
            yield changes_line(finger, lambda name: bench.read([name])[name])


def _records(options: argparse.Namespace) -> bool:
    return bool(options.page) or options.out is not None or options.mcap is not None


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


def _run(
    session: Session,
    options: argparse.Namespace,
    is_over: Callable[[], bool],
    between: Callable[[], object] = lambda: None,
) -> None:
    end = time.monotonic() + options.zero
    if options.zero:
        session.zero()
        session.run(lambda: is_over() or time.monotonic() >= end, between)
        session.zeroed()
    end = time.monotonic() + (np.inf if options.seconds is None else options.seconds)
    session.run(lambda: is_over() or time.monotonic() >= end, between)
    print(f"Readings: {session.counts}.", file=sys.stderr)
    if session.latencies:
        wall, cpu = (1e3 * np.percentile(times, [50, 99]) for times in (session.latencies, session.efforts))
        text = "From a reading to its result: {0:.2f} ms in the median, {1:.2f} ms at 99 %"
        print(f"{text.format(*wall)}; processor time {cpu[0]:.2f} ms and {cpu[1]:.2f} ms.", file=sys.stderr)
