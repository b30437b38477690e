"""soft-gripper export: writes a scenario for another simulator."""

import argparse

from soft_gripper.commands.chosen_station import chosen_scenario
from soft_gripper.errors import InputError
from soft_gripper.extras.export.folder import LOADER, export_mjcf, export_sdf
from soft_gripper.extras.export.mjcf import Mjcf
from soft_gripper.extras.export.sdf import Sdf
from soft_gripper.files.output import lock_folder
from soft_gripper.scenario.scenario_file import files_read


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenario, is_mjcf = chosen_scenario(options), options.to == "mjcf"
    files = ("scenario.xml", "commands.csv", LOADER) if is_mjcf else ("scenario.sdf",)
    if options.time_step and not is_mjcf:
        raise InputError("export", "--time-step", options.time_step, "SDFormat has no time step; --to mjcf has one")
    lock_folder(options.out, files, files_read(options.scenario, scenario))
    if is_mjcf:
        found: Mjcf | Sdf = export_mjcf(scenario, options.out, options.time_step)
    else:
        found = export_sdf(scenario, options.out)
    for part in found.left_out:
        print(f"not exported: {part}")
    if is_mjcf:
        print(f"To run it: pip install mujoco; python {options.out / LOADER}; --view opens MuJoCo's viewer")
    options.console.document["not_exported"] = list(found.left_out)
    options.console.wrote(*(options.out / file for file in (*files, *(f"meshes/{name}" for name in found.meshes))))
