"""Runs a folder that `soft-gripper export` wrote, in MuJoCo: python run_mjcf.py [FOLDER] [--view].

Needs mujoco and numpy, and not soft_gripper. Writes tips.csv: the time, s, the position of every fingertip, m in the
world, and that of every free body.
"""

import csv
import os
import sys
from pathlib import Path
from typing import Any

import numpy as np

PERIOD = 0.01  # s, between the rows of tips.csv


def simulate(folder: Path) -> tuple[list[str], np.ndarray]:
    """Column names and rows of tips.csv."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(folder / "scenario.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    with (folder / "commands.csv").open(newline="") as file:
        header, *commands = list(csv.reader(file))
    # Branches of creep follow the angles of their joints.
    creep = [i for i in range(model.nu) if " creep " in model.actuator(i).name]
    creep_indices = model.jnt_qposadr[model.actuator_trnid[creep, 0]]
    indices = [model.actuator(name).id for name in header[1:]]
    times = np.array([float(row[0]) for row in commands])
    sites = [model.site(i) for i in range(model.nsite)]
    bodies = [
        model.body(model.jnt_bodyid[i]) for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE
    ]
    names = [f"{frame.name} {axis} [m]" for frame in (*sites, *bodies) for axis in "xyz"]
    substeps = max(1, round(PERIOD / model.opt.timestep))
    rows = []
    while data.time < times[-1] - model.opt.timestep / 2:
        control = commands[int(np.searchsorted(times, data.time + 1e-9, side="right")) - 1]
        data.ctrl[indices] = list(map(float, control[1:]))
        data.ctrl[creep] = data.qpos[creep_indices]
        mujoco.mj_step(model, data, substeps)
        mujoco.mj_forward(model, data)
        positions: list[Any] = [data.site_xpos[frame.id] for frame in sites] + [data.xpos[frame.id] for frame in bodies]
        rows.append(np.concatenate([[data.time], *positions]))
    return ["time [s]", *names], np.array(rows)


def main() -> None:
    """Runs a folder, or opens it in MuJoCo's viewer."""
    os.environ["PYTHONSAFEPATH"] = "1"  # glfw starts `python -c`, which would import modules of the current folder
    folders = [argument for argument in sys.argv[1:] if not argument.startswith("--")]
    folder = Path(folders[0]) if folders else Path(__file__).parent
    if "--view" in sys.argv:
        import mujoco.viewer

        mujoco.viewer.launch_from_path(str(folder / "scenario.xml"))
        return
    names, rows = simulate(folder)
    with (folder / "tips.csv").open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows.tolist()])
    for name, value in zip(names, rows[-1], strict=True):
        print(f"{name:<40} {value:.6f}")


if __name__ == "__main__":
    main()
