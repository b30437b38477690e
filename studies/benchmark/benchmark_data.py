"""The simulated contacts and grasps of the benchmark, made again."""

import argparse

from studies.benchmark import contacts, grasps


def run(options: argparse.Namespace) -> None:
    """Writes their files."""
    contacts.write_samples()
    grasps.write_samples()
