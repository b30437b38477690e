"""A task, run once: its recording, its phases as a table and as a picture, in a folder of their own."""

from pathlib import Path

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import atomic_folder
from soft_gripper.pictures.phases import phases_figure
from soft_gripper.runs.scores.phases import phase_table
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario


def run_task(name: str, folder: Path) -> None:
    """Fills `folder`: scenario.yaml, recording.nc, phases.csv and phases.png; all of them or nothing.

    Args:
        name: of a scenario with a task.
        folder: appears when it is whole.
    """
    scenario = load_scenario(name)
    station = make_station(scenario)
    recording = run_station(station)
    assert station.task is not None
    with atomic_folder(folder) as partial:
        recording.save(partial / "recording.nc")
        write_csv(partial / "phases.csv", phase_table(station, recording))
        phases_figure(scenario, recording, station.task.phases).savefig(partial / "phases.png")
        (partial / "scenario.yaml").write_text(dump_scenario(scenario), encoding="utf-8")
