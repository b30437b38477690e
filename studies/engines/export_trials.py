"""Compares random grasps in Drake and, exported, in MuJoCo: held or dropped.

`bottle_grasp`, with a bottle and with a box in turn, of random mass, friction, size, position and orientation, such
that many are dropped. An object is held if it has been lifted by more than half of the lift at the end. Prints
the table of confusion and writes every trial to export_trials.csv. Needs MuJoCo: pip install soft-gripper[mujoco].

Exit code 1: fewer than 95 % agree.
"""

import argparse
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast

from soft_gripper.diagrams.scene import first_body
from soft_gripper.diagrams.simulation import run_to_end
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.extras.export.folder import export_mjcf
from soft_gripper.extras.export.run_mjcf import simulate
from soft_gripper.extras.grasps.adds import Varied
from soft_gripper.extras.grasps.trial import TrialVariation, draw, random_numbers, varied
from soft_gripper.files.output import writable_folder
from soft_gripper.files.row_table import write_csv
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

OBJECTS = {"bottle": 0.00001, "box": 0.03001}  # m, the heights of their frames on the table
MIN_LIFT = 0.04  # m, half of the lift
BAR = 0.95
RANGES = "{offset: 0.004, yaw: 0.5, mass: [0.08, 0.22], friction: [0.4, 0.9], size: 0.1, offset_error: 0, yaw_error: 0}"


@dataclass(frozen=True)
class Lift:
    """Rise of an object in both simulators."""

    object: str
    drake_mm: float
    mujoco_mm: float

    @property
    def is_held(self) -> tuple[bool, bool]:
        """Whether the object is held in Drake and in MuJoCo."""
        return self.drake_mm > 1e3 * MIN_LIFT, self.mujoco_mm > 1e3 * MIN_LIFT


@dataclass(frozen=True)
class Row(Lift, TrialVariation):
    """Lifts of one trial in both simulators, with its random draw."""


def run(options: argparse.Namespace) -> int:
    """Runs the trials; 1 if too few agree."""
    writable_folder(options.out)
    rows = []
    for number in range(options.trials):
        rows.append(run_trial(options.seed, number, options.time_step))
        print(f"{number:>4} {rows[-1].object:<7} {rows[-1].drake_mm:8.2f} {rows[-1].mujoco_mm:8.2f} mm", flush=True)
    write_csv(options.out / "export_trials.csv", rows)
    return report(rows)


def report(rows: Sequence[Row]) -> int:
    """Prints the number of equal trials; 1 if there are too few."""
    for drake, name in ((True, "held in Drake"), (False, "dropped in Drake")):
        counts = [sum(row.is_held == (drake, mujoco) for row in rows) for mujoco in (True, False)]
        print(f"{name:<18} MuJoCo holds {counts[0]:>3}, drops {counts[1]:>3}")
    equal = sum(row.is_held[0] == row.is_held[1] for row in rows)
    print(f"{equal} of {len(rows)} alike; the bar is {BAR:.0%}")
    return int(equal < BAR * len(rows))


def run_trial(seed: int, number: int, time_step: float | None) -> Row:
    """Runs one trial in both simulators."""
    kind = list(OBJECTS)[number % len(OBJECTS)]
    scenario, variation = random_grasp(kind, seed, number)
    lifts = {"drake_mm": 1e3 * drake_lift(scenario), "mujoco_mm": 1e3 * mujoco_lift(scenario, time_step)}
    return Row(**asdict(variation), object=kind, **lifts)


def random_grasp(kind: str, seed: int, number: int) -> tuple[Scenario, TrialVariation]:
    """A scenario whose object is drawn at random."""
    overrides = [f"task.object={kind}", f"task.trials={RANGES}", "record.truth=none", f"models.bottle.name={kind}"]
    height = f"models.bottle.X_PC.translation=[0, 0, {OBJECTS[kind]}]"
    file = f"models.bottle.file=package://soft_gripper/objects/{kind}.obj"
    scenario = load_scenario("bottle_grasp", [height, file, *overrides])
    assert scenario.task is not None
    variation = draw(random_numbers(seed, kind, number), cast(Varied, scenario.task).trials)
    return varied(scenario, variation), variation


def drake_lift(scenario: Scenario) -> float:
    """Rise of the object at the end in Drake, m."""
    station = make_private_station(scenario)
    context = station.plant.GetMyContextFromRoot(run_to_end(station).get_context())
    assert scenario.task is not None
    body = first_body(station.plant, str(scenario.task.object))
    start = station.plant.GetDefaultFloatingBaseBodyPose(body).translation()
    return float((body.EvalPoseInWorld(context).translation() - start)[2])


def mujoco_lift(scenario: Scenario, time_step: float | None) -> float:
    """Rise of the object at the end of the exported folder in MuJoCo, m."""
    with TemporaryDirectory() as folder:
        export_mjcf(scenario, Path(folder), time_step)
        _, rows = simulate(Path(folder))
    return float(rows[-1, -1] - rows[0, -1])
