"""Where the results of a run go: never in silence over those of another."""

import os
import sys
from itertools import count
from pathlib import Path

from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import dump_scenario


def run_folder(asked: Path | None, name: str, scenario: Scenario) -> Path:
    """The folder for the results of a scenario.

    Without one that is asked for, results/NAME, or the first of results/NAME-2, -3 ... that is free or holds this very
    scenario. In one that is asked for, other results are replaced, with a note.
    """
    if asked is not None:
        if not fits(asked, scenario):
            print(f"note: {asked} held the results of another scenario or other settings", file=sys.stderr)
        return asked
    base = Path("results") / name
    found = next(f for f in (base if i == 1 else base.with_name(f"{name}-{i}") for i in count(1)) if fits(f, scenario))
    if found != base:
        print(f"note: {base} holds a run with other settings; the results go to {found}", file=sys.stderr)
    return found


def fits(folder: Path, scenario: Scenario) -> bool:
    """Whether a folder holds no run, or one of just this scenario."""
    file = folder / "scenario.yaml"
    if not os.path.isfile(file):
        return True
    return file.read_text(encoding="utf-8", errors="replace") == dump_scenario(scenario, folder)
