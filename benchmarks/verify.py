"""Fingers in space against what is known of rods, and their grasps: all tables and figures of docs/verification.md.

    SPATIAL_RODS=FOLDER make verification

The folder has solutions of another solver, see `published_rods`; without it, what needs them is left out, as is
PyElastica where it is not installed.
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from verification.figures import draw_compliance, draw_grasps, draw_rods
from verification.grasps import GRASPS, SPATIAL, run
from verification.tables import TABLES


def main() -> None:
    """Prints the tables and draws the figures."""
    for table in TABLES:
        print(f"{table.printed()}\n", flush=True)
    draw_compliance()
    if not draw_rods():
        print(
            "SPATIAL_RODS names no folder with solutions of rods: their tables are empty, and the figure is as it was."
        )
    ways = {False: "bending", True: SPATIAL}
    draw_grasps({(name, way): run(grasp, ways[way]) for name, grasp in GRASPS.items() for way in ways})


if __name__ == "__main__":
    main()
