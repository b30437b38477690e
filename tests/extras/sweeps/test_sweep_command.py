"""The commands sweep and tune: tables, figures, gains."""

import csv
import signal
import subprocess
import time
from pathlib import Path

import pytest
from command_line import LISTENING, complaint, short, soft_gripper

from soft_gripper.commands.parser import parse_options
from soft_gripper.errors import InputError

NOISY = [*short("pressure.settle=0.1"), "--set", "sensor.errors.preset=realistic"]
VARY = ["--vary", "models.0.fingers.all.youngs_modulus=-10..10 %:2", "--vary", "sensor.seed=0..3:4"]
SWEEP = ["sweep", "free_bending", *NOISY, *VARY]


def table(folder: Path) -> bytes:
    return (folder / "sweep.csv").read_bytes()


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A sweep that nothing happened to, by one process."""
    folder = tmp_path_factory.mktemp("sweep") / "whole"
    done = soft_gripper(*SWEEP, "--jobs", 1, "--out", folder)
    assert done.code == 0
    assert "8 runs, 0 failed" in done.out
    return folder


@pytest.mark.slow
def test_table_and_figure(whole):
    files = {"sweep.csv", "sweep.csv.sha256", "sweep.json", "sweep.png", "sweep.svg"}
    assert {path.name for path in whole.iterdir()} == files
    with (whole / "sweep.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["sensor.seed"] for row in rows] == 2 * ["0", "1", "2", "3"]
    assert len({row["mean_pose_error_mm"] for row in rows}) == 8
    assert len({row["largest_bend_deg"] for row in rows}) == 2
    assert float(rows[0]["largest_bend_deg"]) > float(rows[4]["largest_bend_deg"])  # the softer bends more


@pytest.mark.slow
@pytest.mark.parametrize(("rows", "number"), [(0, signal.SIGKILL), (3, signal.SIGTERM)])
def test_killed_and_resumed_by_two_processes_it_comes_to_the_same(whole, tmp_path, rows, number):
    with subprocess.Popen([*LISTENING, *SWEEP, "--jobs", "2", "--out", tmp_path], stderr=subprocess.PIPE) as process:
        file = tmp_path / "sweep.csv"
        while not file.exists() or file.read_bytes().count(b"\n") < 1 + rows:
            assert process.poll() is None
            time.sleep(0.01)
        process.send_signal(number)
    assert len(table(tmp_path)) < len(table(whole))
    done = soft_gripper(*SWEEP, "--jobs", 2, "--out", tmp_path, "--resume")
    assert done.code == 0
    assert table(tmp_path) == table(whole)
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in whole.iterdir()}


def test_a_sweep_of_which_every_run_fails_ends_with_1(tmp_path):
    (tmp_path / "mine.py").write_text("def fails(station, recording): raise ValueError", encoding="utf-8")
    options = "--vary", "sensor.seed=0..1:2", "--measure", tmp_path / "mine.py:fails", "--out", tmp_path / "out"
    assert soft_gripper("sweep", "free_bending", *NOISY, *options, "--jobs", 1).code == 1


SHORT = ("--set", "control.set_points=[0.08, 0.06]", "--set", "control.hold=1")


@pytest.mark.slow
def test_tune_prints_the_table_and_the_gains():
    outcome = soft_gripper("tune", *SHORT, "--evaluations", 5, terminal=True)
    assert outcome.code == 0
    *table, gains = outcome.out.strip().splitlines()
    assert "overshoot" in table[0]
    assert [line.split()[2] for line in table if line.split()[:1] in (["0"], ["1"])] == ["80.0", "60.0"]
    assert gains.startswith("gains: { kp: ")
    assert "5/5" in outcome.err


@pytest.mark.parametrize("choice", ["--method sobol", "--method grid --sample 4"])
def test_a_method_without_its_sample_or_with_it_is_named(choice):
    with pytest.raises(InputError) as error:
        parse_options(f"sweep free_bending --vary sensor.seed=1,2 {choice} --out x".split())
    assert error.value.field == "--method"


@pytest.mark.parametrize("line", ["sweep x --sample few", "sweep x --out", f"sweep x --method {'y' * 50_000} \x1b[2J"])
def test_mistakes_that_argparse_finds_are_one_line(line):
    said = complaint(line)
    assert len(said) < 2000
    assert "\x1b" not in said
