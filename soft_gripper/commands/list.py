"""soft-gripper list: the shipped scenarios."""

import argparse

from soft_gripper.scenario.shipped import descriptions


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    scenarios = descriptions()
    width = max(map(len, scenarios))
    for name, description in scenarios.items():
        print(f"{name:<{width}}  {description}")
    options.console.document["scenarios"] = scenarios
