"""soft-gripper list: the shipped scenarios."""

import argparse

from soft_gripper.scenario.shipped import descriptions


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    known = descriptions()
    width = max(map(len, known))
    for name, description in known.items():
        print(f"{name:<{width}}  {description}")
    options.console.document["scenarios"] = known
