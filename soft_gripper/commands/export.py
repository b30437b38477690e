"""soft-gripper export: writes a scenario for another simulator."""

import argparse

from soft_gripper.commands.chosen_station import chosen_scenario
from soft_gripper.export.folder import LOADER, export_mjcf


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    found = export_mjcf(chosen_scenario(options), options.out)
    for part in found.left_out:
        print(f"not exported: {part}")
    print(f"To run it: pip install mujoco; python {options.out / LOADER}; --view opens MuJoCo's viewer")
    options.console.document["not_exported"] = list(found.left_out)
    files = ("scenario.xml", "commands.csv", LOADER, *(f"meshes/{name}" for name in found.meshes))
    options.console.wrote(*(options.out / file for file in files))
