"""soft-gripper live: readings of hardware in, estimates and commands out, in real time, and a page that shows them."""

import argparse
import os
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from shutil import get_terminal_size
from typing import NamedTuple
from urllib.parse import urlsplit

import numpy as np

from soft_gripper.commands.printing import changes_line
from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.extras.bench.bench import Bench, bench_scenario
from soft_gripper.extras.bench.bench_driver import BenchDriver, recorded_signals
from soft_gripper.extras.bench.endpoints import Endpoints, Sink, Source, file_path
from soft_gripper.extras.bench.live_view import LiveView
from soft_gripper.extras.bench.recorder import Recorder, free_name, recording_layout
from soft_gripper.extras.bench.tally import StatusLine
from soft_gripper.extras.hardware.bench_schema import BenchConfig, load_bench
from soft_gripper.extras.hardware.measured import place_violations
from soft_gripper.extras.hardware.recording_schema import instruments
from soft_gripper.extras.hardware.table import Columns
from soft_gripper.extras.page.session import Session, serve_session
from soft_gripper.files.document import require
from soft_gripper.files.output import check_file, lock_folder
from soft_gripper.interrupts import held_back
from soft_gripper.scenario.scenario_file import files_read
from soft_gripper.scenario.schema import Scenario

_MAX_LOAD = 0.8  # cost of a reading, as a fraction of the period


class _Live(NamedTuple):
    bench: Bench
    config: BenchConfig
    source: Source
    sink: Sink
    moving: list[str]  # fingers


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenario = bench_scenario(options.chosen_scenario)
    file = options.bench or (None if scenario.bench is None else Path(scenario.bench))
    if options.mcap is not None and options.page:
        raise InputError("live", "--mcap", str(options.mcap), "records a whole session: leave it, or --page, out")
    if options.json_lines and (options.sink or options.page):
        raise InputError("live", "--json", True, "prints the results on standard output: leave --sink and --page out")
    if file is None:
        expected = (
            "describe the hardware in a file, and name it by --bench or in the scenario; see docs/extras/bench/live.md"
        )
        raise InputError(options.scenario, "bench", None, expected)
    folder, recording = _outputs(options)
    with held_back() as is_interrupted, Endpoints(file, is_interrupted if options.fast else None) as endpoints:
        live = _open_bench(scenario, file, endpoints, options)
        make_driver: Callable[..., BenchDriver] = BenchDriver
        if options.page:
            make_driver = partial(LiveView, moving=live.moving)
        driver = make_driver(live.bench, live.config, live.source, live.sink, is_live=not options.fast, say=_say)
        if recording is not None:
            layout = recording_layout(live.bench, recorded_signals(live.bench, live.config))
            driver.recorder = Recorder(live.bench, layout, recording)
        _say_pace(driver, live, options.fast)
        if options.zero:
            driver.zero(options.zero)
        end = np.inf if options.seconds is None else time.monotonic() + options.zero + options.seconds
        session = Session(driver, folder)

        def is_over() -> bool:
            return is_interrupted() or time.monotonic() >= end

        try:
            if folder is None:
                session.run(is_over)
            else:
                if options.out is not None:
                    session.record()
                serve_session(session, "live", options, scenario, is_over, _say)
        finally:
            _sum_up(driver, endpoints.dropped)
    for finger in live.bench.quantities:
        if f"{finger}.bend_change" in live.bench.signals:  # of `recursive`
            _say(changes_line(finger, lambda name: live.bench.read([name])[name]))
    if options.mcap is not None and recording is not None:
        Recording.load(recording).save(options.mcap)
        _say(f"Recording written: {options.mcap}")


def _outputs(options: argparse.Namespace) -> tuple[Path | None, Path | None]:
    """Folder of a page's recordings, and path of the single recording of a session without a page."""
    if options.page:
        return lock_folder(options.out or Path("results") / "live" / Path(options.scenario).stem), None
    if options.mcap is not None:
        check_file(options.mcap)
    if options.out is not None:
        return None, free_name(lock_folder(options.out) / "recording.nc")
    return None, None if options.mcap is None else free_name(options.mcap.with_suffix(".nc"))


def _say_pace(driver: BenchDriver, live: _Live, is_fast: bool) -> None:
    """Prints the measured cost of a reading, and whether the machine can keep the rate."""
    fingers = len(live.bench.quantities)
    period = live.bench.period
    name = live.bench.scenario.estimator.type
    signals = driver.sent
    cost = live.bench.cost(signals)
    rate = f"a reading every {1e3 * period:g} ms"
    cost_text = f"takes {1e3 * cost.processor:.1f} ms of processor time here"
    _say(f"{fingers} finger{'s' * (fingers != 1)}, {name}: {rate} {cost_text}.")
    if is_fast:
        return
    if cost.processor > _MAX_LOAD * period:
        expected = f"choose a longer sensor.period, another estimator, or fewer signals in `send` than {len(signals)}"
        _say(f"note: this machine cannot keep that rate, and readings will be lost: {expected}")
    elif cost.elapsed > _MAX_LOAD * period:
        clock_text = f"with other programs running, it takes {1e3 * cost.elapsed:.1f} ms by the clock"
        _say(f"note: {clock_text}, and readings will be lost, which are counted: stop other programs")


def _sum_up(driver: BenchDriver, dropped: int) -> None:
    """Ends a recording, and prints a summary of the session."""
    if driver.recorder is not None:
        driver.recorder.close()
        _say(f"The last recording is {driver.recorder.report}.")
    for line in (*driver.tally.lines(), *driver.calibration.lines()):
        _say(line)
    _say(f"Readings: {driver.counts}; {dropped} results that nobody read in time.")
    if driver.malformed:
        _say(f"The first malformed message {driver.malformed}.")
    if driver.command_age_text:
        _say(f"{driver.command_age_text.capitalize()}.")
    if driver.latencies:
        wall, cpu = (1e3 * np.percentile(times, [50, 99]) for times in (driver.latencies, driver.efforts))
        text = "From a reading to its result: {0:.2f} ms in the median, {1:.2f} ms at 99 %"
        _say(f"{text.format(*wall)}; processor time {cpu[0]:.2f} ms and {cpu[1]:.2f} ms.")


def _say(line: str) -> None:
    erased = "\033[K" if sys.stderr.isatty() else ""  # what is left of the status line
    print(f"{erased}{line}", file=sys.stderr, flush=True)


def _open_bench(scenario: Scenario, file: Path, endpoints: Endpoints, options: argparse.Namespace) -> _Live:
    description = load_bench(file)
    config = replace(description, source=options.source or description.source, sink=options.sink or description.sink)
    config = replace(config, sink_format="json") if options.json_lines else config
    moving = [name for name, finger in config.fingers.items() if finger.base_pose is not None]
    inputs = [f"{name}.measured_{kind}" for name, finger in config.fingers.items() for kind in instruments(finger)]
    bench = Bench(scenario, moving, inputs)
    check_inputs(file, config, bench)
    columns = (
        None if config.time is None else Columns(dict.fromkeys(config.names, "fields"), config.time, hold=config.hold)
    )
    _check_files(scenario, file, config, options)
    source = endpoints.source(config.source, 0.0 if options.fast else bench.period, columns)
    return _Live(bench, config, source, _sink(endpoints, config.sink, bench, config, options), moving)


def _check_files(scenario: Scenario, file: Path, config: BenchConfig, options: argparse.Namespace) -> None:
    """Checks that no output replaces an input of this command, or a file that the command line does not name."""
    outputs = [options.mcap] if options.mcap is not None else []
    if config.sink is not None and config.sink.startswith("file:"):
        sink = file_path(urlsplit(config.sink))
        outputs += [] if sink.is_fifo() else [sink]  # a pipe is opened when it is written to
        is_named = options.sink is not None or not os.path.isfile(sink)
        require(is_named, file, "sink", config.sink, "exists, and would be emptied: name it by --sink, or another file")
    for output in outputs:
        check_file(output, [*files_read(options.scenario, scenario), file, config.source.removeprefix("file:")])


def _sink(
    endpoints: Endpoints, address: str | None, bench: Bench, config: BenchConfig, options: argparse.Namespace
) -> Sink:
    """Opens the sink of results: without an address, the page or a status line."""
    if options.json_lines:
        if address is not None:
            raise InputError("live", "--json", True, f"the description sends the results to {address}: leave one out")
        return endpoints.sink("stdio:")
    if address is None and options.page:
        return lambda *_: None
    if address is None:
        width = get_terminal_size().columns if sys.stdout.isatty() else None
        return endpoints.queued_sink(StatusLine(bench, config.pressure_unit, width))
    return endpoints.sink(address)


def check_inputs(file: Path, config: BenchConfig, bench: Bench) -> None:
    """Checks that the bench that a file describes measures all that its estimators need.

    Raises:
        InputError: if it does not.
    """
    sizes = {
        f"{name}.{kind}": len(fields)
        for name, finger in config.fingers.items()
        for kind, fields in (
            ("pressure", finger.pressures),
            ("tension", finger.tensions),
            ("X_WB", finger.base_pose or []),
        )
    }
    sizes |= {
        bench.quantities[name]: len(finger.readings)
        for name, finger in config.fingers.items()
        if name in bench.quantities
    }
    sizes |= {f"{name}.measured_{kind}": 2 for name, finger in config.fingers.items() for kind in instruments(finger)}
    unknown_names = config.fingers.keys() - bench.quantities.keys()
    if unknown_names:
        raise InputError(file, "fingers", sorted(unknown_names), f"the scenario has: {', '.join(bench.quantities)}")
    for name, size in bench.inputs.items():
        field_count = int(config.opening is not None) if name == "grip.set_point" else sizes.get(name, 0)
        if field_count != size:
            raise InputError(file, name, f"{field_count} fields", f"must be {size}")
    for name, finger in config.fingers.items():
        for kind, instrument in instruments(finger).items():
            place = np.array([np.nan if instrument.place is None else instrument.place])
            field = f"fingers.{name}.measured_{kind}.place"
            for violation in place_violations(field, place, bench.layouts[name].finger.length):
                raise InputError(file, *violation)
    for field, signals in (("send", config.send), ("record", config.record)):
        names = [name for name in signals or () if name not in bench.signals]
        if names:
            raise InputError(file, field, names, f"known signals: {', '.join(bench.signals)}")
