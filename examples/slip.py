"""Studies slip: how creep and loss of an object depend on conditions, in Drake and in MuJoCo, and are predicted.

    python examples/slip.py

Two fingers lift a bottle (scenario `bottle_grasp`) and hold it for some seconds. One condition is changed at a time.
With mujoco installed, the exported model runs too. Then random grasps are predicted from the forces before the lift.
"""

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import cached_station, run_station
from soft_gripper.extras.export.folder import export_mjcf
from soft_gripper.extras.export.run_mjcf import simulate
from soft_gripper.extras.sweeps.axes import read_axis, sweep_points
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.study import results
from soft_gripper.extras.sweeps.sweep import run_sweep
from soft_gripper.files.row_table import print_rows, write_csv
from soft_gripper.runs.scores.slipping import as_predicted
from soft_gripper.scenario.scenario_file import changed_scenario

SCENARIO = "bottle_grasp"
OBJECT = "bottle"
HELD_FOR, CREPT = 4.0, 2.0  # s after the lift, and at the end of that, over which creep is measured
LIFT, SLIPPED = 0.08, 0.01  # m: of the gripper, and less of the object, which then has slipped
CHANGES = {"models.bottle.friction": 0.3, "task.phases.lift.rest": HELD_FOR}
STEP, CONTACT, FRICTION, MASS = "plant_config.time_step", "contact", "models.bottle.friction", "models.bottle.mass"
CONDITIONS: dict[str, dict[str, Any]] = {
    "60 g, friction 0.3, steps of 5 ms": {},
    "steps of 10 ms": {STEP: 0.01},
    "steps of 2.5 ms": {STEP: 0.0025},
    "steps of 1 ms": {STEP: 0.001},
    "friction 0.8": {FRICTION: 0.8},
    "friction 0.2": {FRICTION: 0.2},
    "friction 0.12": {FRICTION: 0.12},
    "30 g": {MASS: 0.03},
    "120 g": {MASS: 0.12},
}
IN_DRAKE: dict[str, dict[str, Any]] = {
    "contact at 4 points": {CONTACT: "points"},
    "contact at 8 points": {CONTACT: "points", "contact_points": 8},
    "stiction tolerance 1e-3 m/s": {"plant_config.stiction_tolerance": 1e-3},
}
NOSLIP = 'noslip_iterations="10"'  # of exported models
RANDOM = (
    "models.bottle.friction=0.1..0.9",
    "models.bottle.mass=0.03..0.12",
    "models.bottle.X_PC.translation.0=-0.004..0.004",
    "pressure.steps.all.0=40e3..130e3",
)


@dataclass(frozen=True)
class SlipRow:
    """The bottle under one condition: the speed at which it sinks while it is held; NaN if it has slipped."""

    condition: str
    creep_per_s_mm: Annotated[float, ".3f"]


def creep(time: Array, height: Array) -> float:
    """Speed at which a lifted object sinks at the end, mm/s; NaN if it has slipped.

    Args:
        time: (T,) s.
        height: of the object, (T,) m.
    """
    last = time >= time[-1] - CREPT
    has_slipped = height[-1] - height[0] < LIFT - SLIPPED
    return np.nan if has_slipped else -1e3 * float(np.polyfit(time[last], height[last], 1)[0])


def drake_creep(changes: Mapping[str, Any]) -> float:
    """Speed at which the bottle sinks in Drake, mm/s, see `creep`."""
    recording = run_station(cached_station(changed_scenario(SCENARIO, {**CHANGES, **changes})))
    return creep(recording["time"].values, recording[f"{OBJECT}.pose"].values[:, -1])


def mujoco_creep(changes: Mapping[str, Any], noslip: bool) -> float:
    """Speed at which the bottle sinks in the exported model in MuJoCo, mm/s, see `creep`."""
    scenario = changed_scenario(SCENARIO, {**CHANGES, **changes})
    with TemporaryDirectory() as folder:
        export_mjcf(scenario, Path(folder), scenario.plant_config.time_step)
        model = Path(folder) / "scenario.xml"
        text = model.read_text(encoding="utf-8")
        assert NOSLIP in text
        if not noslip:
            model.write_text(text.replace(NOSLIP, ""), encoding="utf-8")
        names, rows = simulate(Path(folder))
    return creep(rows[:, 0], rows[:, names.index(f"{OBJECT}::{OBJECT} z [m]")])


def conditions(executor: Executor) -> list[SlipRow]:
    """A row for each condition and simulator."""
    drake = results(executor, drake_creep, {name: (change,) for name, change in (CONDITIONS | IN_DRAKE).items()})
    rows = [SlipRow(f"Drake: {name}", speed) for name, speed in drake.items()]
    if find_spec("mujoco") is not None:
        for noslip, words in ((True, "MuJoCo"), (False, "MuJoCo without noslip")):
            rows += [SlipRow(f"{words}: {name}", mujoco_creep(change, noslip)) for name, change in CONDITIONS.items()]
    return rows


def predictions(trials: int, seed: int, executor: Executor, out: Path) -> tuple[int, int]:
    """Numbers of random grasps with a prediction before the lift, and of those that end as predicted."""
    points = sweep_points([read_axis(text) for text in RANDOM], "latin", trials, seed)
    rows = run_sweep(SCENARIO, points, out, executor)
    predicted = [row for row in rows if row["predicted"]]
    return len(predicted), sum(as_predicted(row["predicted"], row["grasp"]) for row in predicted)


def main(trials: int = 100, seed: int = 2, jobs: int = 2, out: str = "results/slip") -> None:
    """Runs the study, writes its tables and prints them."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    with open_executor(jobs) as executor:
        rows = conditions(executor)
        write_csv(folder / "conditions.csv", rows)
        print_rows(rows, "A bottle that two fingers have lifted")
        predicted, right = predictions(trials, seed, executor, folder / "random")
    print(f"{trials} random grasps, seed {seed}: {predicted} predicted before the lift, {right} of them rightly")


if __name__ == "__main__":
    main()
