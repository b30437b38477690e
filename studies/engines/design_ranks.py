"""Compares the ranks of designs in MuJoCo and in Drake.

Some designs of a study that hold their object are exported, evenly spread over the rank of their force. In
MuJoCo the fingers close on the object of the scenario, at the pressure of the design, with the arm at rest. The normal
force of the finger that presses most is compared with `normal_force_n` of the search, the mean over its draws.
"""

import argparse
import csv
import tempfile
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
from scipy.stats import spearmanr

from soft_gripper.arrays import Array
from soft_gripper.extras.design.run_design import DESIGN
from soft_gripper.extras.design.study_file import DesignStudy, load_design_study
from soft_gripper.extras.design.study_tables import DESIGNS
from soft_gripper.extras.export.folder import export_mjcf
from soft_gripper.files.yaml_text import parse_yaml
from soft_gripper.scenario.scenario_file import changed_scenario

MEASURE = "normal_force_n"
CLOSING_CHANGES = {"pressure.settle": 3.0, "pressure.hold_samples": 50}


def run(options: argparse.Namespace) -> None:
    """Prints a row for each design, and the rank fit."""
    study = load_design_study(options.study)
    with (options.results / DESIGNS).open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if "0" != row["held"] == row["runs"] and row[DESIGN] != "0"]
    rows.sort(key=lambda row: float(row[MEASURE]))
    chosen = [rows[i] for i in np.unique(np.linspace(0, len(rows) - 1, options.designs).round().astype(int))]
    drake_forces, mujoco_forces = [], []
    print(f"{'design':>6} {'Drake [N]':>10} {'MuJoCo [N]':>11}")
    for row in chosen:
        drake_forces.append(float(row[MEASURE]))
        mujoco_forces.append(normal_force(study, row))
        print(f"{row[DESIGN]:>6} {drake_forces[-1]:>10.3f} {mujoco_forces[-1]:>11.3f}", flush=True)
    fit = spearmanr(drake_forces, mujoco_forces)
    print(f"Spearman's rank correlation of {len(chosen)} designs: {fit.statistic:.3f} (p = {fit.pvalue:.1g})")


def normal_force(study: DesignStudy, row: dict[str, str]) -> float:
    """Largest normal force of a finger in MuJoCo, N."""
    values = {axis.key: parse_yaml("design", f"value: {row[axis.key]}")["value"] for axis in study.axes}
    scenario = replace(changed_scenario(study.scenario, {**study.fixed, **CLOSING_CHANGES, **values}), task=None)
    with tempfile.TemporaryDirectory() as folder:
        export_mjcf(scenario, Path(folder), 0.002)
        model, data = close_fingers(Path(folder))
    return max(finger_forces(model, data).values(), default=0.0)


def close_fingers(folder: Path) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Runs an exported folder with constant commands in MuJoCo to its end."""
    model = mujoco.MjModel.from_xml_path(str(folder / "scenario.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    with (folder / "commands.csv").open(newline="") as file:
        header, first, *_, last = list(csv.reader(file))
    data.ctrl[[model.actuator(name).id for name in header[1:]]] = list(map(float, first[1:]))
    mujoco.mj_step(model, data, round(float(last[0]) / model.opt.timestep))
    mujoco.mj_forward(model, data)
    return model, data


def finger_forces(model: mujoco.MjModel, data: mujoco.MjData) -> dict[str, float]:
    """Sum of the normal forces of each finger on free bodies, N."""
    free = {int(model.jnt_bodyid[i]) for i in range(model.njnt) if model.jnt_type[i] == mujoco.mjtJoint.mjJNT_FREE}
    forces: dict[str, float] = {}
    for number in range(data.ncon):
        bodies = [int(model.geom_bodyid[geom]) for geom in data.contact[number].geom]
        finger_links = [model.body(body).name for body in bodies if body not in free]
        if len(finger_links) == 1 and "_link_" in finger_links[0]:
            force: Array = np.zeros(6)
            mujoco.mj_contactForce(model, data, number, force)
            finger = finger_links[0].partition("_link_")[0]
            forces[finger] = forces.get(finger, 0.0) + float(force[0])
    return forces
