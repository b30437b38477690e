"""Commands killed at random moments: nothing half written, no process left, and what resumes comes to the same.

KILLS of every command, each time others (`make kills`), or a few that are always the same.
"""

import os
import random
import signal
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from command_line import LISTENING, short
from processes import Process, processes

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import dump_scenario, load_scenario

pytestmark = pytest.mark.slow

KILLS = int(os.environ.get("KILLS", "0"))
RANDOM = random.Random(None if KILLS else 1)
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
PARTS = [*short("pressure.settle=0.1"), "--set", "sensor.errors.preset=realistic"]
SWEEP = [
    "sweep",
    "free_bending",
    *PARTS,
    "--vary",
    "sensor.seed=0..5:6",
    "--vary",
    "sensor.sections=1,2",
    "--jobs",
    "2",
]
TRIALS = ["grasp-trials", "--scenario", "brief.yaml", "--trials", "6", "--jobs", "2"]
RUN = ["run", "free_bending", *short()]
RESUMED = {"sweep": (SWEEP, "sweep.csv"), "grasp-trials": (TRIALS, "trials.csv")}


class Place:
    """A folder to work in, whose processes and temporary files are known by it."""

    def __init__(self, folder: Path, temporary: Path):
        self.folder, self.temporary = folder, temporary
        brief = load_scenario("pick_and_place_box", ["task.time_limit=0.5", "estimator.contact_threshold=0.012"])
        (folder / "brief.yaml").write_text(dump_scenario(brief))
        self.environment = {**os.environ, "TMPDIR": str(self.temporary)}

    def popen(self, arguments: list[str], out: str) -> "subprocess.Popen[bytes]":
        command = [*LISTENING, *arguments, "--out", out]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return subprocess.Popen(command, cwd=self.folder, env=self.environment, start_new_session=True, **quiet)

    def finish(self, arguments: list[str], out: str) -> float:
        """Runs a command to its end; how long it took, s."""
        began = time.monotonic()
        with self.popen(arguments, out) as process:
            assert process.wait() == 0
        return time.monotonic() - began

    def left_alive(self, session: int) -> list[Process]:
        """What of a session still runs after ten seconds."""
        until = time.monotonic() + 10
        while (alive := [one for one in processes() if one.session == session]) and time.monotonic() < until:
            time.sleep(0.1)
        return alive

    def kill_at_random(self, arguments: list[str], out: str, lasts: float) -> None:
        with self.popen(arguments, out) as process:
            time.sleep(RANDOM.uniform(0.1, 0.95) * lasts)
            process.send_signal(RANDOM.choice(SIGNALS))
        assert not self.left_alive(process.pid)


@pytest.fixture
def temporary() -> Iterator[Path]:
    """A short path, for the sockets in it."""
    with TemporaryDirectory(prefix="kills-") as folder:
        yield Path(folder)


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("command", RESUMED)
def test_what_is_resumed_comes_to_the_same(command, tmp_path, temporary):
    arguments, table = RESUMED[command]
    place = Place(tmp_path, temporary)
    lasts = place.finish(arguments, "whole")
    for i in range(KILLS or 1):
        out = f"killed_{i}"
        place.kill_at_random(arguments, out, lasts)
        place.finish([*arguments, "--resume"], out)
        assert (tmp_path / out / table).read_bytes() == (tmp_path / "whole" / table).read_bytes()
        assert files(tmp_path / out) == files(tmp_path / "whole")
    assert not files(place.temporary)


def test_a_run_leaves_whole_files_or_none(tmp_path, temporary):
    place = Place(tmp_path, temporary)
    lasts = place.finish(RUN, "whole")
    for i in range(KILLS or 1):
        out = tmp_path / f"killed_{i}"
        place.kill_at_random(RUN, out.name, lasts)
        left = {name for name in files(out) if not name.startswith(".")} if out.exists() else set()
        assert left <= files(tmp_path / "whole")
        for name in left:
            if name == "recording.nc":
                assert len(Recording.load(out / name).data["time"]) > 0
            elif name.endswith(".csv"):
                assert (out / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
        place.finish(RUN, out.name)
        assert files(out) == files(tmp_path / "whole")
