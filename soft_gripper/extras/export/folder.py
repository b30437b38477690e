"""A folder that another simulator runs: the model, its meshes, the commands over time, and a loader."""

from pathlib import Path

from soft_gripper.extras.export.actuation import table
from soft_gripper.extras.export.mjcf import Mjcf, to_mjcf
from soft_gripper.files.output import atomic_file, check_file, writable_folder
from soft_gripper.scenario.schema import Scenario

LOADER = "run_mjcf.py"


def export_mjcf(scenario: Scenario, out: Path, time_step: float | None = None) -> Mjcf:
    """Writes scenario.xml, meshes, commands.csv and a loader that needs MuJoCo alone.

    `time_step` is that of `to_mjcf`.

    Raises:
        InputError: if the scenario cannot be exported, a mesh would be replaced by another one, or the folder cannot be
            written to.
    """
    mjcf = to_mjcf(scenario, time_step)
    files = {
        "scenario.xml": mjcf.text.encode(),
        "commands.csv": table(mjcf.actuators, mjcf.commands).encode(),
        LOADER: Path(__file__).with_name(LOADER).read_bytes(),
        **{f"meshes/{name}": source.read_bytes() for name, source in mjcf.meshes.items()},
    }
    for name in mjcf.meshes:
        check_file(out / f"meshes/{name}", mjcf.meshes.values())
    for name, content in files.items():
        writable_folder((out / name).parent)
        with atomic_file(out / name) as partial:
            partial.write_bytes(content)
    return mjcf
