"""However a session of `live` ends, its last command is safe and its recording is whole; no output holds it up."""

import os
import re
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper
from live_process import LIVE, NAMES, SAFE, Running, bench, line
from refusals import refusal
from waiting import LONG, wait_until

from soft_gripper.diagrams.recording import Recording


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    bench(tmp_path)
    return tmp_path


def live(*options):
    Path("results.csv").unlink(missing_ok=True)
    return soft_gripper(*LIVE, "--bench", "bench.yaml", "--fast", *options)


def last(file="results.csv"):
    return Path(file).read_text().splitlines()[-1]


def test_a_number_that_cannot_be_is_malformed(here):
    bad = dict(enumerate([1e30, -1e30, 1e4, "nan", "inf", "1e400"], 5))
    lines = [
        line(i, **({"pa": bad[i]} if i in bad else {"a1": bad[i - 10]} if i - 10 in bad else {})) for i in range(30)
    ]
    Path("readings.csv").write_text("".join(lines))
    done = live("--out", "out")
    assert done.code == 0
    assert "18 used, 12 lost, 0 late, 0 repeated, 12 malformed" in done.err
    assert "The first malformed message has " in done.err
    assert last().endswith(SAFE)
    assert Recording.load("out/recording.nc").data.sizes["time"] == 30


ENDS = 15.0  # s, by which a session has ended at the latest
OWN = """
def fails_later():
    for i in range(10):
        yield {"n": float(i), **dict.fromkeys(NAMES, 0.001)}
    raise ZeroDivisionError("the ADC is gone")


def taking(results):
    if results["count"] == 5:
        raise KeyError("valve")


""".replace("NAMES", repr(NAMES))


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--source", "own:fails_later"], ["source", "own:fails_later", "ZeroDivisionError: the ADC is gone"]),
        (["--sink", "own:taking"], ["sink", "own:taking", "KeyError", "valve"]),
    ],
)
def test_own_functions_that_fail_end_in_one_line(here, options, words):
    Path("own.py").write_text(OWN)
    done = live(*options, "--out", "out")
    assert done.code == 2
    assert "Traceback" not in done.err
    said = done.err.splitlines()[-1]
    assert all(word in said for word in words)
    assert Recording.load("out/recording.nc").data.sizes["time"] >= 5
    if "--source" in options:
        assert last().endswith(SAFE)


def test_an_estimator_that_fails_leaves_a_safe_command_and_the_recording(here, monkeypatch):
    from soft_gripper.extras.bench.bench import Bench

    step = Bench.step

    def fails(self, measured):
        if np.any(measured.get("left_finger.pressure") == 20e3):
            raise np.linalg.LinAlgError("Singular matrix")
        step(self, measured)

    monkeypatch.setattr(Bench, "step", fails)
    Path("readings.csv").write_text("".join(line(i, **({"pa": 20.0} if i == 12 else {})) for i in range(30)))
    done = live("--out", "out")
    assert done.code == 2
    assert "the estimators failed: LinAlgError: Singular matrix" in done.err.splitlines()[-1]
    assert last().endswith(SAFE)
    assert Recording.load("out/recording.nc").data.sizes["time"] == 12


@pytest.mark.parametrize("sink", ["readings.csv", "./readings.csv", "bench.yaml", "link.csv"])
def test_no_sink_replaces_what_is_read(here, sink):
    Path("link.csv").symlink_to("readings.csv")
    before = Path("readings.csv").read_text()
    assert "is an input of this command" in refusal(*LIVE, "--bench", "bench.yaml", "--fast", "--sink", f"file:{sink}")
    assert Path("readings.csv").read_text() == before


@pytest.mark.parametrize("sink", ["file:thesis.txt", "file:///{here}/thesis.txt", "file:thesis%2Etxt", "file:link.txt"])
def test_no_sink_of_a_description_empties_a_file(here, sink):
    Path("thesis.txt").write_text("years")
    Path("link.txt").symlink_to("thesis.txt")
    bench = Path("bench.yaml").read_text()
    Path("bench.yaml").write_text(re.sub("^sink: .*$", f"sink: '{sink.format(here=here)}'", bench, flags=re.MULTILINE))
    assert "would be emptied: name it by --sink" in refusal(*LIVE, "--bench", "bench.yaml", "--fast")
    assert Path("thesis.txt").read_text() == "years"
    assert live("--sink", "file:thesis.txt").code == 0
    assert Path("thesis.txt").read_text() != "years"


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_reader_that_stalls_holds_nothing_up(here, number):
    """Results beyond what the pipe takes are dropped; any signal ends it, and all readings were used."""
    read, write = os.pipe()
    with Running(here, "--set", "sensor.period=0.01", stdout=write) as live:
        os.set_blocking(write, False)
        try:
            while True:  # the pipe is full from now on
                os.write(write, bytes(4096))
        except BlockingIOError:
            os.set_blocking(write, True)
        live.feed(3.0)
        wait_until(live.has_read_all)
        time.sleep(0.2)  # for the last of them
        began = time.monotonic()
        live.process.send_signal(number)
        code = live.process.wait(LONG)
        assert time.monotonic() - began < ENDS
        said = live.process.stderr.read()
    os.close(read)
    os.close(write)
    assert code == 0
    used, lost = (int(re.findall(rf"(\d+) {word}", said)[0]) for word in ("used", "lost"))
    assert used + lost == 300
    assert int(re.findall(r"(\d+) results that nobody read", said)[0]) > 150
