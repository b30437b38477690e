"""soft-gripper export: writes a scenario for another simulator."""

import argparse

from soft_gripper.commands.chosen_station import chosen_scenario
from soft_gripper.errors import InputError
from soft_gripper.export.folder import LOADER, export_mjcf, export_sdf
from soft_gripper.export.mjcf import Mjcf
from soft_gripper.export.sdf import Sdf


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenario, is_mjcf = chosen_scenario(options), options.to == "mjcf"
    if is_mjcf:
        found: Mjcf | Sdf = export_mjcf(scenario, options.out, options.time_step)
    elif options.time_step:
        raise InputError("export", "--time-step", options.time_step, "SDFormat has no time step; --to mjcf has one")
    else:
        found = export_sdf(scenario, options.out)
    for part in found.left_out:
        print(f"not exported: {part}")
    if is_mjcf:
        print(f"To run it: pip install mujoco; python {options.out / LOADER}; --view opens MuJoCo's viewer")
    files = ("scenario.xml", "commands.csv", LOADER) if is_mjcf else ("scenario.sdf",)
    options.console.document["not_exported"] = list(found.left_out)
    options.console.wrote(*(options.out / file for file in (*files, *(f"meshes/{name}" for name in found.meshes))))
