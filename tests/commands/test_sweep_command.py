"""soft-gripper sweep: the same table from one process, from two, and after SIGKILL; and what it refuses."""

import csv
import signal
import subprocess
import time
from pathlib import Path

import pytest
from command_line import LISTENING, short, soft_gripper

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
    assert {path.name for path in whole.iterdir()} == {
        "sweep.csv",
        "sweep.csv.sha256",
        "sweep.json",
        "sweep.png",
        "sweep.svg",
    }
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
