"""Soft bodies between plates, against closed forms: the tables of docs/extras/soft/soft_objects.md."""

import argparse

from studies.verification.soft_bodies import BALLS, BLOCKS


def run(options: argparse.Namespace) -> None:
    """Prints the tables."""
    for table in (BLOCKS, BALLS):
        print(f"{table.printed()}\n", flush=True)
