"""soft-gripper export: writes a scenario for MuJoCo."""

import argparse

from soft_gripper.extras.export.folder import LOADER, export_mjcf
from soft_gripper.files.output import lock_folder
from soft_gripper.scenario.scenario_file import files_read


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenario = options.chosen_scenario
    files = ("scenario.xml", "commands.csv", LOADER)
    lock_folder(options.out, files, files_read(options.scenario, scenario))
    exported = export_mjcf(scenario, options.out, options.time_step)
    for part in exported.left_out:
        print(f"not exported: {part}")
    print(f"To run it: pip install mujoco; python {options.out / LOADER}; --view opens MuJoCo's viewer")
    options.console.document["not_exported"] = list(exported.left_out)
    options.console.wrote(*(options.out / file for file in (*files, *(f"meshes/{name}" for name in exported.meshes))))
