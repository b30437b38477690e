"""The evaluation: scenarios side by side in processes, then the tables, figures and claims of them all."""

import signal
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from multiprocessing import active_children, get_context
from multiprocessing.queues import Queue
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.evaluation.claims import Claim, claims
from soft_gripper.evaluation.csv_table import read_csv, write_csv
from soft_gripper.evaluation.figures import contact_figure, free_bending_figure, save_figure
from soft_gripper.evaluation.force_figure import force_figure
from soft_gripper.evaluation.force_table import ForceRow
from soft_gripper.evaluation.pose_table import PoseRow
from soft_gripper.evaluation.scenario_run import is_finished, run_scenario

FREE = "free_bending"
CONTACT = ("obstructed_inside", "obstructed_outside", "box_grasp", "irregular_grasp")
SCENARIOS = (FREE, *CONTACT)
Advance = Callable[[float], Any]
_times: "Queue[float]"  # of a worker: where it reports the simulated time that it has added


@dataclass(frozen=True)
class Evaluation:
    """The tables of all scenarios, and what follows from them."""

    poses: list[PoseRow]
    forces: list[ForceRow]
    claims: list[Claim]


def unfinished(out: Path) -> list[str]:
    """Scenarios of which `out` holds no whole run."""
    return [name for name in SCENARIOS if not is_finished(out / name, load_scenario(name))]


def run_scenarios(names: Sequence[str], out: Path, jobs: int, advance: Advance) -> None:
    """Runs scenarios in `jobs` processes, each into its own folder below `out`.

    Args:
        advance: called with the seconds of simulated time that were added, of all scenarios together.

    Raises:
        InputError, SimulationDivergedError: if a scenario fails; the others are finished first.
    """
    context = get_context("spawn")
    times: Queue[float] = context.Queue()
    longest_first = sorted(names, key=lambda name: -len(load_scenario(name).models))
    with ProcessPoolExecutor(jobs, context, _begin_worker, (times,)) as pool:
        pending: set[Future[None]] = {pool.submit(_work, name, out / name) for name in longest_first}
        finished: set[Future[None]] = set()
        try:
            while pending:
                done, pending = wait(pending, timeout=0.1, return_when=FIRST_COMPLETED)
                finished |= done
                while not times.empty():
                    advance(times.get())
        except KeyboardInterrupt:
            for worker in active_children():
                worker.terminate()
            raise
    for future in finished:
        future.result()


def _begin_worker(times: "Queue[float]") -> None:
    """Leaves Ctrl-C to the parent, and keeps the way to report progress."""
    global _times
    _times = times
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _work(name: str, folder: Path) -> None:
    last = 0.0

    def report(time: float) -> None:
        nonlocal last
        _times.put(time - last)
        last = time

    run_scenario(name, folder, report)


def summarize(out: Path) -> Evaluation:
    """Writes metrics.csv, forces.csv and the figures from the finished scenarios in `out`."""
    poses = [row for name in SCENARIOS for row in read_csv(out / name / "metrics.csv", PoseRow)]
    forces = [row for name in SCENARIOS for row in read_csv(out / name / "forces.csv", ForceRow)]
    write_csv(out / "metrics.csv", poses)
    write_csv(out / "forces.csv", forces)
    free = [row for row in poses if row.scenario == FREE]
    save_figure(free_bending_figure(free), out / "fig5_free_bending")
    save_figure(contact_figure(poses, CONTACT, "pose_error_mm"), out / "fig6_pose_error")
    save_figure(contact_figure(poses, CONTACT, "tip_error_mm"), out / "fig7_fingertip_error")
    save_figure(force_figure(forces, CONTACT), out / "force_estimate")
    return Evaluation(poses, forces, claims(poses, forces))
