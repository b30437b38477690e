"""soft-gripper live: with a file of readings, and what it refuses."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper
from refusals import refusal

from soft_gripper.diagrams.recording import Recording

BENCH = """
source: file:readings.txt
format: text
sink_format: json
fields: [n, t, {names}, pl, pr]
count: n
time: t
pressure_unit: kPa
fingers:
  left_finger: {{ readings: [{left}], pressures: [pl] }}
  right_finger: {{ readings: [{right}], pressures: [pr] }}
"""


def bench(folder, **changes):
    """A description of ten readings of straight fingers in a file; the fourth is missing, the sixth is malformed."""
    left, right = ([f"{side}{i}" for i in range(8)] for side in "ab")
    text = BENCH.format(names=", ".join([*left, *right]), left=", ".join(left), right=", ".join(right))
    for old, new in changes.get("instead", {}).items():
        assert old in text
        text = text.replace(old, new)
    rows = [",".join(["n", "t", *left, *right, "pl", "pr"])]
    rows += [",".join(map(str, [i, 0.01 * i, *[0.0] * 16, 1.5, 1.5])) for i in range(10) if i != 3]
    rows[5] = rows[5].replace("0.0", "nan")
    (folder / "readings.txt").write_text("\n".join(rows) + "\n")
    (folder / "bench.yaml").write_text(text)
    return ["tip_distance_steps", "--bench", "bench.yaml", "--fast"]


def test_a_file_of_readings(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = soft_gripper("live", *bench(tmp_path), "--json", "--out", "out", "--set", "estimator.type=gaussian")
    assert done.code == 0
    results = [json.loads(line) for line in done.out.splitlines()]
    assert [found["count"] for found in results[:-1]] == [0, 1, 2, 4, 6, 7, 8, 9]
    assert results[-1]["stale"] == 1
    assert results[-1]["left_finger.pressure_command"] == [0.0]
    assert "8 used, 2 lost, 0 late, 0 repeated, 1 malformed" in done.err
    recording = Recording.load(tmp_path / "out" / "recording.nc")
    pressures = recording["left_finger.sampled_pressure"].values.ravel()
    assert pressures[-1] == 1500.0
    assert np.isnan(recording["left_finger.strain"].values).all(axis=(1, 2)).sum() == 2


@pytest.mark.parametrize("options", [[], ["--source", "udp://:0"], ["--page"], ["--out", "out"]])
def test_without_a_description_there_is_no_hardware(tmp_path, monkeypatch, options):
    """Nothing takes its place."""
    monkeypatch.chdir(tmp_path)
    line = refusal("live", "tip_distance_steps", *options)
    assert all(word in line for word in ("tip_distance_steps", "bench = None", "--bench"))
    assert not list(tmp_path.iterdir())


def test_without_json_a_line_says_what_is_known(tmp_path, monkeypatch):
    """Ten readings take less than the time between two lines."""
    monkeypatch.chdir(tmp_path)
    done = soft_gripper("live", *bench(tmp_path))
    assert done.code == 0
    (line,) = done.out.splitlines()
    assert "live" in line
    assert "left_finger: tip " in line
    assert line.endswith("0 lost")


def test_json_takes_no_other_sink(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for other in (["--sink", "stdio:"], ["--page"]):
        assert "leave --sink and --page out" in refusal("live", "tip_distance_steps", "--json", *other)


@pytest.mark.parametrize(
    ("instead", "words"),
    [
        ({"pressures: [pl]": "pressures: []"}, ["bench.yaml", "left_finger.pressure", "0 fields", "must be 1"]),
        ({"left_finger:": "thumb:"}, ["bench.yaml", "fingers", "thumb", "left_finger, right_finger"]),
        ({"count: n": "count: number"}, ["bench.yaml", "fields", "must have 'number'"]),
        ({"time: t": "send: [left_finger.smile]"}, ["bench.yaml", "send", "left_finger.smile", "known signals"]),
        ({"format: text": "format: float32"}, ["bench.yaml", "source", "carries lines"]),
        ({"a0, a1, a2": "a0, a1"}, ["bench.yaml", "fields"]),
    ],
)
def test_what_is_refused(tmp_path, monkeypatch, instead, words):
    monkeypatch.chdir(tmp_path)
    line = refusal("live", *bench(tmp_path, instead=instead))
    assert all(word in line for word in words)


def test_a_task_that_grips(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert "may not command the gripper of a bench" in refusal("live", "pick_and_place_box")


EXAMPLES = Path(__file__).parents[3] / "examples" / "bench"


def test_the_line_of_a_microcontroller_is_what_its_description_says(tmp_path, monkeypatch):
    """A count, eight strains and two pressures; two sections per side."""
    monkeypatch.chdir(tmp_path)
    text = (EXAMPLES / "two_fingers.yaml").read_text()
    text = text.replace("source: serial:///dev/ttyACM0?baud=115200", "source: file:lines.txt")
    (tmp_path / "bench.yaml").write_text(
        text.replace("sink: serial:///dev/ttyACM0?baud=115200", "sink: file:answers.txt")
    )
    (tmp_path / "lines.txt").write_text("".join(f"{i},{','.join(['0.0'] * 8)},1.0,1.0\n" for i in range(5)))
    live = ["live", "tip_distance_steps", "--bench", "bench.yaml", "--set", "sensor.sections=2", "--fast"]
    done = soft_gripper(*live)
    assert done.code == 0
    answers = [line.split(",") for line in (tmp_path / "answers.txt").read_text().splitlines()]
    assert {len(answer) for answer in answers[:-1]} == {7}
    assert answers[-2][0] == "4"
