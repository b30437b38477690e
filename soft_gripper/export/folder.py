"""A folder that another simulator runs: the model, its meshes, the commands over time, and a loader."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.wiring.drive import OF, steps_of
from soft_gripper.export.mjcf import Mjcf, to_mjcf
from soft_gripper.export.sdf import Sdf, to_sdf
from soft_gripper.files.output import atomic_file, writable_folder
from soft_gripper.scenario.schema import Scenario

LOADER = "run_mjcf.py"


def export_mjcf(scenario: Scenario, out: Path) -> Mjcf:
    """Writes scenario.xml, meshes, commands.csv and a loader that needs MuJoCo alone.

    Raises:
        InputError: if the scenario cannot be exported, or the folder cannot be written to.
    """
    found = to_mjcf(scenario)
    files = {
        "scenario.xml": found.text.encode(),
        "commands.csv": _commands(scenario, found).encode(),
        LOADER: Path(__file__).with_name(LOADER).read_bytes(),
    }
    _write(out, files, found.meshes)
    return found


def export_sdf(scenario: Scenario, out: Path) -> Sdf:
    """Writes scenario.sdf and meshes. Raises what `export_mjcf` does."""
    found = to_sdf(scenario)
    _write(out, {"scenario.sdf": found.text.encode()}, found.meshes)
    return found


def _write(out: Path, files: dict[str, bytes], meshes: Mapping[str, Path]) -> None:
    """Writes files, and copies of meshes in a folder of their own."""
    for name, content in (files | {f"meshes/{name}": source.read_bytes() for name, source in meshes.items()}).items():
        writable_folder((out / name).parent)
        with atomic_file(out / name) as partial:
            partial.write_bytes(content)


def _commands(scenario: Scenario, found: Mjcf) -> str:
    """Times, s, from which commands hold, and the commands: pressures, Pa, and positions of an arm, rad or m."""
    chambers = found.actuators[: len(found.actuators) - len(found.arm)]
    columns = [_pressures(scenario, name) for name in chambers] + [[value] for value in found.arm]
    count = scenario.steps
    held = np.array([[*column, *[column[-1]] * (count - len(column))] for column in columns]).reshape(-1, count).T
    times: Array = np.arange(count) * scenario.step_duration
    rows = [[time, *row] for time, row in zip(times, held, strict=True)]
    rows.append([max(scenario.duration if scenario.task is None else 0.0, count * scenario.step_duration), *held[-1]])
    lines = [",".join(["time [s]", *found.actuators]), *(",".join(repr(float(x)) for x in row) for row in rows)]
    return "\n".join(lines) + "\n"


def _pressures(scenario: Scenario, chamber: str) -> list[float]:
    """The pressure of a chamber at each step, Pa; 0 in a closed loop."""
    if scenario.control.set_points is not None:
        return [0.0]
    finger, _, own = chamber.partition(OF)
    steps = steps_of("pressure", scenario.pressure.steps, finger, [own] if own else ())
    return [float(step) for step in steps[:, 0]]
