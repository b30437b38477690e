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
from identified import BEAM, RELEASED, finger_of, recorded, release, write_motion
from processes import Process, processes

from soft_gripper.diagrams.recording import Recording
from soft_gripper.extras.hardware.identification.identified_finger import read_finger, read_setup
from soft_gripper.extras.paper.evaluate import RUNS
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario

pytestmark = pytest.mark.slow

KILLS = int(os.environ.get("KILLS", "0"))
RANDOM = random.Random(None if KILLS else 1)
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGHUP, signal.SIGINT)
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
TRIALS = ["study", "grasp-trials", "--scenario", "brief.yaml", "--trials", "4", "--jobs", "2"]
RESUMED = {"sweep": (SWEEP, "sweep.csv"), "trials": (TRIALS, "trials.csv")}
RUN = ["run", "free_bending", *short()]
IDENTIFY = ["identify", "run.csv", "--finger", "guess.urdf", "--free", "youngs_modulus", "--jobs", "2"]
BEGUN_ANEW = {"run": (RUN, "{}"), "identify": (IDENTIFY, "{}/fitted.urdf")}  # with what goes after --out
EVALUATE, EVALUATES = ["evaluate", "--jobs", "2"], 60.0  # s, in which its first scenarios end


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


def write_recording_of_a_beam(folder: Path) -> None:
    """run.csv of a beam that is let go, recording.yaml that says what is in it, and guess.urdf."""
    motion = recorded(finger_of(BEAM, folder), release(0.8))
    write_motion(folder / "run.csv", motion.time, motion.markers)
    (folder / "recording.yaml").write_text(RELEASED)
    (folder / "guess.urdf").write_text(
        BEAM.replace('material="dragon_skin_10"', 'youngs_modulus="2.75e5" density="1070"')
    )


def whole_files(folder: Path) -> set[str]:
    """Those that a user sees."""
    return {name for name in files(folder) if not name.startswith(".")}


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


@pytest.mark.parametrize("command", BEGUN_ANEW)
def test_what_is_killed_leaves_whole_files_or_none(command, tmp_path, temporary):
    arguments, out = BEGUN_ANEW[command]
    place = Place(tmp_path, temporary)
    write_recording_of_a_beam(tmp_path)
    lasts = place.finish(arguments, out.format("whole"))
    for i in range(KILLS or 1):
        folder = tmp_path / f"killed_{i}"
        place.kill_at_random(arguments, out.format(folder.name), lasts)
        left = whole_files(folder) if folder.exists() else set()
        assert left <= files(tmp_path / "whole")
        for name in left:
            if name == "recording.nc":
                assert len(Recording.load(folder / name).data["time"]) > 0
            elif name.endswith(".urdf"):  # as far as the search had come
                assert read_finger(folder / name).name == "beam"
                read_setup(folder / name)
            elif name.endswith(".csv"):
                assert (folder / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
        place.finish(arguments, out.format(folder.name))
        assert files(folder) == files(tmp_path / "whole")


def test_an_evaluation_that_is_killed_leaves_whole_scenarios(tmp_path, temporary):
    place = Place(tmp_path, temporary)
    for i in range(KILLS or 1):
        folder = tmp_path / f"killed_{i}"
        place.kill_at_random(EVALUATE, folder.name, EVALUATES)
        scenarios = {name.split("/")[0] for name in whole_files(folder) if "/" in name} if folder.exists() else set()
        assert scenarios <= set(RUNS)
        for scenario in scenarios:
            assert {"scenario.yaml", "recording.nc"} <= files(folder / scenario)
            assert len(Recording.load(folder / scenario / "recording.nc").data["time"]) > 0
    assert not files(place.temporary)
