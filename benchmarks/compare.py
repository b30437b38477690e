"""Compares this checkout with another one: `python compare.py OTHER [SCENARIO ...]`.

OTHER is a folder in which `make .venv/ready` was run. The checkouts take turns, each run in a process of its own and
timed by the checkout's own timed_run.py. For every part of a run the mean of its two shortest times counts, which
excludes as much as possible of the machine's other load.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
ROUNDS = 7
SCENARIOS = ("free_bending", "box_grasp", "irregular_grasp", "pick_and_place_box")
Runs = dict[tuple[str, str], list[list[float]]]  # times of the parts, by checkout and diagram


def main(other: Path, scenarios: list[str]) -> None:
    """Prints a line per scenario."""
    print("scenario               faster  blocks  closed / bare, other  closed / bare, here")
    for name in scenarios or SCENARIOS:
        times = {key: shortest(runs) for key, runs in run_in_turns(other, name).items()}
        here, there = times["here", "closed"], times["other", "closed"]
        bare = min((time for (_, diagram), time in times.items() if diagram == "bare"), default=np.nan)
        numbers = there / here, (here - bare) / (there - bare), there / bare, here / bare
        print(f"{name:<22} {numbers[0]:>6.2f} {numbers[1]:>7.2f} {numbers[2]:>21.2f} {numbers[3]:>20.2f}", flush=True)


def run_in_turns(other: Path, scenario: str) -> Runs:
    """Runs of a scenario in both checkouts."""
    runs: Runs = {}
    for _ in range(ROUNDS):
        for checkout, folder in (("other", other), ("here", HERE.parent)):
            folder = folder.resolve()
            command = [folder / ".venv/bin/python", folder / "benchmarks/timed_run.py", scenario]
            found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
            for diagram, times in found.items():
                runs.setdefault((checkout, diagram), []).append(times)
    return runs


def shortest(runs: list[list[float]]) -> float:
    """Computing time of a run, s, of the shortest times of its parts."""
    return float(np.sort(np.array(runs), axis=0)[:2].mean(axis=0).sum())


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:]) if len(sys.argv) > 1 else sys.exit(__doc__)
