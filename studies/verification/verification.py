"""Fingers in space against what is known of rods, and their grasps: all tables and figures of docs/verification.md.

With `--soft` soft bodies between plates against closed forms: the tables of studies/verification/README.md.

The folder that the environment variable SPATIAL_RODS names has solutions of another solver, see `published_rods`;
without it, what needs them is left out, as is PyElastica where it is not installed.
"""

import argparse

from studies.verification.figures import draw_compliance, draw_grasps, draw_rods
from studies.verification.grasps import GRASPS, SPATIAL
from studies.verification.grasps import run as run_grasp
from studies.verification.soft_bodies import BALLS, BLOCKS
from studies.verification.tables import TABLES


def run(options: argparse.Namespace) -> None:
    """Prints the tables and draws the figures."""
    for table in (BLOCKS, BALLS) if options.soft else TABLES:
        print(f"{table.printed()}\n", flush=True)
    if options.soft:
        return
    draw_compliance()
    if not draw_rods():
        print("SPATIAL_RODS names no folder with solutions of rods: their tables are empty, the figure is as it was.")
    ways = {False: "bending", True: SPATIAL}
    draw_grasps({(name, way): run_grasp(grasp, ways[way]) for name, grasp in GRASPS.items() for way in ways})
