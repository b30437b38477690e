"""Compares fingers in space with solutions of rods, and their grasps: all tables and figures of docs/verification.md.

`--soft` compares soft bodies between plates with closed forms: the tables of studies/verification/README.md.

The folder that the environment variable SPATIAL_RODS names has solutions of another solver, see `published_rods`;
without it, their tables are left out, as is PyElastica if it is not installed.
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
        print(f"{table.to_markdown()}\n", flush=True)
    if options.soft:
        return
    draw_compliance()
    if not draw_rods():
        print("SPATIAL_RODS names no folder with solutions of rods: their tables are empty, the figure is as it was.")
    yields = {False: "bending", True: SPATIAL}
    draw_grasps(
        {(name, spatial): run_grasp(grasp, yields[spatial]) for name, grasp in GRASPS.items() for spatial in yields}
    )
