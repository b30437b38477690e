"""soft-gripper grasp-strength: loads a held object in twelve directions until it is lost."""

import argparse
import math
from pathlib import Path

from soft_gripper.commands.chosen_station import station_of
from soft_gripper.diagrams.simulation import check_closed
from soft_gripper.extras.grasps.strength import LOADS, NOT_HELD, Shake, grasp_strength, held_object, strength_figure
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_rows
from soft_gripper.pictures.style import save_figure

TABLE, FIGURE = "strength.csv", "strength"


def run(options: argparse.Namespace) -> int:
    """Runs the command; the exit code is 1 if there is no grasp to test."""
    scenario = options.chosen_scenario
    name = Path(options.scenario).stem
    object_name = held_object(scenario, options.object)
    check_closed(station_of(options.scenario, scenario))
    lock_folder(options.out)
    shake = Shake(1e-3 * options.slid, math.radians(options.turned), options.seconds)
    executor = open_executor(options.jobs, options.scheduler)
    with count_jobs(options.console, len(LOADS), "loads", "nothing is kept") as report, executor as processes:
        rows = grasp_strength(scenario, processes, object_name, shake, report)
    options.console.table("strength", rows, options.out / TABLE)
    save_figure(strength_figure(rows, f"{name}: strength of the grasp of {object_name}"), options.out / FIGURE)
    print_rows(rows, f"Grasp of {object_name}: the largest load that it withstands beside the weight")
    print(
        f"It is lost if it slides by {options.slid:g} mm along the fingers, or turns by {options.turned:g} degrees in"
    )
    print("them; moved and turned are in the palm: the fingers yield too, so they may exceed these limits.")
    print("Stiffness: N/mm along, mN m/degree about an axis; x: the first finger closes, z: it points")
    options.console.wrote(*(options.out / file for file in (TABLE, f"{FIGURE}.png", f"{FIGURE}.svg")))
    return int(all(row.ended == NOT_HELD for row in rows))
