"""Simulates the contacts and grasps of the benchmark again, and writes their files."""

import argparse

from studies.benchmark import contacts, grasps


def run(options: argparse.Namespace) -> None:
    """Writes their files."""
    contacts.write_samples()
    grasps.write_samples()
