"""Nothing that arrives during a live session ends it, and its recording is whole.

As in `test_fuzz`, the inputs follow from a fixed seed, and `make fuzz` tries many more.
"""

import json
import os
import signal
from contextlib import contextmanager
from copy import copy
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from live_inputs import CHANGES, FIELDS, SCENARIO, frames, objects, streams
from live_process import BENCH
from test_fuzz import PROFILE

from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.extras.bench.bench_driver import BenchDriver, recorded_signals
from soft_gripper.extras.bench.endpoints import Endpoints, LineSource
from soft_gripper.extras.bench.live_view import LiveView
from soft_gripper.extras.bench.messages import encoded
from soft_gripper.extras.bench.recorder import Recorder, recording_layout
from soft_gripper.extras.hardware.bench_schema import load_bench
from soft_gripper.extras.page.live_page import SessionPage
from soft_gripper.extras.page.session import Session
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = [pytest.mark.slow, pytest.mark.filterwarnings("error::RuntimeWarning")]

LIMIT = 60  # s of a session, which takes a tenth of one as a rule
SAFE = -5.0  # kPa
LINKS = "lines", "file", "datagrams"
FORMS = "json", "text", "float64"


class Datagrams:
    """A source that has all messages at once."""

    def __init__(self, messages):
        self._messages = messages

    @property
    def is_over(self):
        return not self._messages

    def receive(self, timeout):
        messages, self._messages = self._messages, []
        return messages


@pytest.fixture(scope="module")
def made():
    """A bench, its description and the layout of its recordings; the bench is begun anew for every session."""
    bench = Bench(load_scenario(SCENARIO, CHANGES))
    with TemporaryDirectory() as folder:
        file = Path(folder) / "bench.yaml"
        file.write_text(BENCH.format(source="file:readings.csv", sink="stdio:"))
        config = load_bench(file)
    return bench, config, recording_layout(bench, recorded_signals(bench, config))


@contextmanager
def within(seconds):
    """Raises a TimeoutError if the block takes longer."""

    def end(*_):
        raise TimeoutError

    before = signal.signal(signal.SIGALRM, end)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@contextmanager
def source(link, messages, folder):
    """The messages as they come over a link."""
    content = b"".join(message + b"\n" for message in messages)
    if link == "datagrams":
        yield Datagrams(messages)
        return
    (folder / "readings.csv").write_bytes(content)
    if link == "file":
        with Endpoints("fuzz") as endpoints:
            yield endpoints.source(f"file:{folder / 'readings.csv'}")
        return
    descriptor = os.open(folder / "readings.csv", os.O_RDONLY)
    yield LineSource(descriptor)
    os.close(descriptor)


def begun(made, form, incoming, is_live, kind=BenchDriver):
    """A driver of a bench that begins anew, and its results."""
    bench, config, _ = made
    bench, config, results = copy(bench), copy(config), []
    bench._begin()
    config.format, config.fields, config.sink_format = form, FIELDS, "json"
    driver = kind(bench, config, incoming, lambda _, found: results.append(found), is_live=is_live)
    return driver, bench, results


def check_results(results):
    """Every result can be sent, and the last one is safe."""
    for result in results:
        assert json.loads(encoded(result, "json")).keys() == result.keys()
    assert results[-1]["stale"] == 1.0
    for name in ("left_finger.pressure_command", "right_finger.pressure_command"):
        assert results[-1][name] == SAFE


@contextmanager
def refused_lines(link):
    """Lets pass that a line without an end is refused, if it is of a file; of a device it is malformed."""
    try:
        yield
    except InputError as error:
        if link != "file" or error.field != "line":
            raise


@pytest.mark.parametrize("link", LINKS)
@pytest.mark.parametrize("form", FORMS)
def test_hostile_messages(link, form, made):
    if form == "float64" and link != "datagrams":
        pytest.skip("packed numbers do not come in lines")

    @PROFILE
    @given(messages=streams(form), is_live=st.booleans())
    def try_one(messages, is_live):
        with TemporaryDirectory(prefix="fuzz-") as name, within(LIMIT), source(link, messages, Path(name)) as incoming:
            driver, bench, results = begun(made, form, incoming, is_live)
            driver.recorder = Recorder(bench, made[2], Path(name) / "recording.nc")
            with refused_lines(link):
                Session(driver).run(lambda: False)
            driver.recorder.close()
            counts, known = driver.counts, Recording.load(Path(name) / "recording.nc")["reading.count"].values
        check_results(results)
        assert np.isfinite(known).sum() == counts.used
        if link == "datagrams":
            of_each = counts.used, counts.malformed, counts.excess, counts.late, counts.repeated
            assert sum(of_each) == len(messages)

    try_one()


def test_hostile_objects(made):
    @PROFILE
    @given(messages=objects())
    def try_one(messages):
        with within(LIMIT):
            driver, _, results = begun(made, "json", Datagrams(messages), False)
            Session(driver).run(lambda: False)
        check_results(results)
        counts = driver.counts
        assert counts.used + counts.malformed + counts.late + counts.repeated == len(messages)

    try_one()


@pytest.fixture(scope="module")
def page(made, tmp_path_factory):
    """A page of a session that goes on, and what gives that a reading."""
    incoming = Datagrams([])
    driver, *_ = begun(made, "text", incoming, False, LiveView)
    folder = tmp_path_factory.mktemp("page")
    session = Session(driver, folder)
    return SessionPage({}, driver.panel, session.feed), session, driver, folder


def test_hostile_frames(page):
    live, session, driver, folder = page

    @PROFILE
    @given(sent=frames())
    def try_one(sent):
        heard = []
        with within(LIMIT):
            for frame in sent:
                live.take(frame, heard.append)
                session.step()
            used = driver.counts.used
            driver._source._messages = [encoded(dict.fromkeys(FIELDS, 0.001) | {"n": float(used)}, "text").strip()]
            driver.advance()
            assert driver.counts.used == used + 1, "the session goes on"
        for text in heard:
            json.loads(text)

    try_one()
    session.run(lambda: True)
    for file in folder.rglob("recording.nc"):
        assert "reading.count" in Recording.load(file).data
