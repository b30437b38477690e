"""Soft bodies between plates, against closed forms: the tables of docs/extras/soft/soft_objects.md.

make verification-soft
"""

import os

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

from verification.soft_bodies import BALLS, BLOCKS


def main() -> None:
    """Prints the tables."""
    for table in (BLOCKS, BALLS):
        print(f"{table.printed()}\n", flush=True)


if __name__ == "__main__":
    main()
