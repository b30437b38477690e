"""What a box grasp of 4 s costs in MuJoCo, with one process and with two.

    python benchmarks/many_grasps.py [RUNS]

Sensors are realistic, the estimator is `gaussian`, and pose, mass and friction of the box are random: of boxes that
fingers hold, and of some that they do not. Times are those of the whole command on an idle machine; the tables of one
process and of two are compared.
"""

import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

from soft_gripper.files.row_table import print_rows

SAMPLES = {  # kg, friction
    "held": ((0.05, 0.15), (0.5, 1.0)),
    "near the limit": ((0.05, 0.3), (0.3, 1.0)),
}
FIXED = {
    "pressure.steps": "{all: [30e3, 60e3, 90e3, 120e3]}",
    "pressure.settle": 0.5,
    "pressure.hold_samples": 50,
    "sensor.errors.preset": "realistic",
    "estimator.type": "gaussian",
}


@dataclass(frozen=True)
class Cost:
    """What a sweep costs."""

    boxes: str
    runs: int
    processes: int
    ms_a_run: Annotated[float, ".0f"]
    seconds: Annotated[float, ".0f"]
    same_table: str


def main() -> None:
    """Prints the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    costs = []
    for boxes in SAMPLES:
        with TemporaryDirectory() as folder:
            tables = [Path(folder) / str(jobs) for jobs in (1, 2)]
            found = [cost(boxes, runs, jobs, table) for jobs, table in enumerate(tables, start=1)]
            one, two = ((table / "sweep.csv").read_bytes() for table in tables)
            same = "yes" if one == two else "no"
            costs += [Cost(boxes, runs, jobs, *each, same) for jobs, each in enumerate(found, start=1)]
    print_rows(costs)


def cost(boxes: str, runs: int, jobs: int, out: Path) -> tuple[float, float]:
    """Time of a run, ms, and of all, s, of a sweep."""
    (light, heavy), (smooth, rough) = SAMPLES[boxes]
    varied = {"mass": (light, heavy), "friction": (smooth, rough), "X_PC.translation.0": (-0.004, 0.004)}
    command = ["soft-gripper", "sweep", "box_grasp", "--engine", "mujoco", "--sample", str(runs), "--seed", "7"]
    command += ["--jobs", str(jobs), "--out", str(out)]
    for key, (least, most) in varied.items():
        command += ["--vary", f"models.box.{key}={least}..{most}"]
    for key, value in FIXED.items():
        command += ["--set", f"{key}={value}"]
    command[0] = str(Path(sys.executable).with_name(command[0]))
    began = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    seconds = time.perf_counter() - began
    return 1e3 * seconds / runs, seconds


if __name__ == "__main__":
    main()
