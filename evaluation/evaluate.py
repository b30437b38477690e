"""The evaluation: scenarios run once each, and what comes out of them for 1 to 4 sensors."""

from pathlib import Path

from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import Progress, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.evaluation.claims import Claim, free_bending_claims
from soft_gripper.evaluation.figures import free_bending_figure, save_figure
from soft_gripper.evaluation.pose_table import PoseRow, pose_table, write_csv

SECTIONS = (1, 2, 3, 4)


def evaluate(out: Path, progress: Progress | None = None) -> tuple[list[PoseRow], list[Claim]]:
    """Runs the free-bending scenario and writes metrics.csv, the recording and Fig. 5 into `out`."""
    name = "free_bending"
    station = make_station(load_scenario(name))
    recording = run_station(station, progress=progress)
    rows = pose_table(name, station, recording, SECTIONS)
    recording.save(out / f"{name}.nc")
    write_csv(out / "metrics.csv", rows)
    save_figure(free_bending_figure(rows), out / "fig5_free_bending")
    return rows, free_bending_claims(rows)
