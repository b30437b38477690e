"""Draws the uncertainty of the force on a finger: small across the line from its base to the contact, large along it.

    python examples/pictures/force_ellipses.py

holds a box and a bottle and presses a peg, with four realistic sections, and draws results/force_ellipses.png.
"""

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.estimators.plane import to_base
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.shape_figure import draw_base, draw_segments
from soft_gripper.pictures.style import STYLE, save_figure
from soft_gripper.runs.scores.poses import held_rows
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, corners

CASES = {"box_grasp": "a box", "obstructed_inside": "a peg", "bottle_grasp": "a bottle"}
SENSORS = ["estimator.type=contact", "sensor.sections=4", "sensor.errors.preset=realistic"]
_FINGER_COLOR, _LINE_COLOR, _TRUE_COLOR, _ESTIMATE_COLOR = "#f8d9c6", "0.55", "#111111", "#0072b2"
_CHI_QUANTILE = 2.4477  # radius that holds 95 % of two normal variables of deviation 1
_MM_PER_N = 30.0
_X_LIMITS, _Z_LIMITS = (-60.0, 25.0), (205.0, -15.0)  # mm, limits of the drawings


@dataclass(frozen=True)
class Press:
    """The contact force on a finger at the end of a run, in the bending plane: x and z in B."""

    finger: Finger
    corners: Array  # (N + 2, 3) m, base, joints, tip
    point: Array  # (2) m, of the contact on the axis, as estimated
    force: Array  # (2) N, as estimated
    covariance: Array  # (2, 2) N^2
    true: Array  # (2) N


def read_press(name: str) -> Press:
    """Simulates a scenario and reads the force on its first finger."""
    scenario = load_scenario(name, SENSORS)
    station = make_private_station(scenario)
    recording = run_station(station)
    last = held_rows(scenario, recording)[-1, -1]
    finger = station.fingers[0]

    def signal(signal: str) -> Array:
        values: Array = recording[f"{finger.name}.{signal}"].values[last]
        return values

    corner = corners(signal(TRUE_JOINTS), signal(TRUE_TIP))
    joints = np.vstack([[0.0, 0.0, 0.0], signal("estimated_joint_positions"), signal("estimated_tip_position")])[:, ::2]
    ends = np.concatenate([[0.0], finger.finger.joint_arc_lengths, [finger.finger.length]])
    point = np.array([np.interp(signal("contact_arc_length"), ends, axis) for axis in joints.T])
    covariance = signal("contact_force_vector_covariance").reshape(3, 3)[::2, ::2]
    true = to_base(signal("X_WB"), signal("true_contact_force_world"))[::2]
    return Press(finger.finger, corner, point, signal("contact_force_vector")[::2], covariance, true)


def ellipses_figure(presses: dict[str, Press]) -> Figure:
    """Each finger with the force on it, true and estimated, and the ellipse that holds 95 %."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.2, 5.0), layout="constrained")
        for axes, (name, press) in zip(figure.subplots(1, len(presses), sharey=True), presses.items(), strict=True):
            _draw(axes, press)
            axes.set_title(CASES[name])
        figure.axes[0].set_ylabel("z [mm]")
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure


def _draw(axes: Axes, press: Press) -> None:
    draw_base(axes, press.finger)
    draw_segments(axes, press.finger, press.corners, np.tile(to_rgb(_FINGER_COLOR), (press.finger.segments, 1)))
    point = 1e3 * press.point
    axes.plot(*np.array([[0.0, 0.0], point]).T, "--", color=_LINE_COLOR, lw=1, label="line from the base")
    for force, color, label in ((press.true, _TRUE_COLOR, "true force"), (press.force, _ESTIMATE_COLOR, "estimate")):
        arrow = {"arrowstyle": "-|>", "color": color, "lw": 1.4, "mutation_scale": 9, "shrinkA": 0, "shrinkB": 0}
        axes.annotate("", point + _MM_PER_N * force, point, arrowprops=arrow)
        axes.plot([], [], color=color, lw=1.4, label=f"{label}, {_MM_PER_N:g} mm/N")
    turn = np.linspace(0, 2 * np.pi, 100)
    around = np.linalg.cholesky(press.covariance) @ np.array([np.cos(turn), np.sin(turn)])
    ellipse = point[:, None] + _MM_PER_N * (press.force[:, None] + _CHI_QUANTILE * around)
    axes.fill(*ellipse, color=_ESTIMATE_COLOR, alpha=0.25, lw=0, label="95 % of the estimate")
    axes.set(aspect="equal", xlim=_X_LIMITS, ylim=_Z_LIMITS, xlabel="x [mm]")


def main(stem: Path = Path("results/force_ellipses")) -> None:
    """Prints and draws the forces."""
    presses = {name: read_press(name) for name in CASES}
    for name, press in presses.items():
        line = press.point / np.linalg.norm(press.point)
        across = np.array([line[1], -line[0]])
        along, over = (np.sqrt(n @ press.covariance @ n) for n in (line, across))
        print(f"{name}: standard deviation {along:.2f} N along the line, {over:.2f} N across it")
    stem.parent.mkdir(parents=True, exist_ok=True)
    save_figure(ellipses_figure(presses), stem)


if __name__ == "__main__":
    main()
