"""How soft objects give way in a gripper that carries them: a sponge, a tomato, and a block of silicone rubber.

    python examples/pictures/soft_grasps.py

runs the scenarios pick_and_place_sponge, _tomato and _silicone, prints a table, and draws results/soft_grasps.png.
"""

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import phase_spans
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.pictures.rendering import Picture, SceneRenderer, framing_camera
from soft_gripper.pictures.style import STYLE, save_figure
from soft_gripper.runs.scores.recorded_task import Judged, judged
from soft_gripper.scenario.scenario_file import load_scenario

OBJECTS = ("sponge", "tomato", "silicone")
_OBJECT_COLORS = {"sponge": "#d9a400", "tomato": "#c22b1c", "silicone": "#2d7fa6"}
_CARRY_PHASE = "carry"
_HEIGHT, _WIDTH = 620, 620  # pixels
_PICTURE_MARGIN = 0.05  # m, of the fingers over the object that are in the picture


@dataclass(frozen=True)
class SoftGrasp:
    """A soft object that is picked up, carried and put down."""

    modulus: float  # Pa
    time: Array  # (T,) s, from the beginning of closing
    force: Array  # (T,) N, mean normal force of the fingers
    squeeze: Array  # (T,) m
    strain: Array  # (T,)
    picture: Picture  # while it is carried
    result: Judged


def run_grasp(name: str) -> SoftGrasp:
    """Simulates the scenario of an object."""
    scenario = load_scenario(f"pick_and_place_{name}")
    station = make_private_station(scenario)
    recording = run_station(station)
    assert station.task is not None
    spans = {span.phase.name: span for span in phase_spans(recording, station.task.phases)}
    time = recording["time"].values
    from_closing = (time >= spans["close"].begin) & (time < spans["retreat"].begin)
    force, squeeze, strain = (
        recording[f"{name}.{signal}"].values[from_closing]
        for signal in ("grip_normal_force", "squeeze", "largest_strain")
    )
    (mesh,) = (model.mesh for model in scenario.models if model.name == name)
    assert mesh.youngs_modulus is not None
    middle = (spans[_CARRY_PHASE].begin + spans[_CARRY_PHASE].end) / 2
    return SoftGrasp(
        mesh.youngs_modulus,
        time[from_closing] - spans["close"].begin,
        force.mean(axis=1),
        squeeze,
        strain,
        _picture(SceneRenderer(scenario, recording), name, middle),
        judged(station, recording),
    )


def _picture(renderer: SceneRenderer, name: str, time: float) -> Picture:
    """The object and the fingertips."""
    points = renderer.scene.signals(time)[f"{name}.vertices"].values
    corners = renderer.scene.gripper_corners(time)
    tips = corners[corners[:, 2] < points[:, 2].max() + _PICTURE_MARGIN]
    camera = framing_camera(np.concatenate([points, tips]), _HEIGHT, _WIDTH, renderer.direction)
    return renderer.render(time, camera)


def soft_figure(grasps: dict[str, SoftGrasp]) -> Figure:
    """Each object while it is carried, its squeeze over time, and force against squeeze as the fingers close."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.6, 6.2), layout="constrained")
        above, below = (np.repeat(names, 6 // len(names)).tolist() for names in (OBJECTS, ("time", "force")))
        panels = figure.subplot_mosaic([above, below], height_ratios=[1.25, 1])
        for letter, (name, grasp) in zip("abc", grasps.items(), strict=True):
            panels[name].imshow(grasp.picture)
            panels[name].axis("off")
            panels[name].set_title(f"({letter}) {name}, {1e-3 * grasp.modulus:g} kPa")
        _draw_curves(panels["time"], panels["force"], grasps)
    return figure


def _draw_curves(over_time: Axes, over_squeeze: Axes, grasps: dict[str, SoftGrasp]) -> None:
    for name, grasp in grasps.items():
        squeeze = 1e3 * grasp.squeeze
        over_time.plot(grasp.time, squeeze, color=_OBJECT_COLORS[name], lw=1.4, label=name)
        closing = slice(0, int(np.argmax(grasp.force > 0.95 * grasp.force.max())) + 1)
        touching = grasp.force[closing] > 0
        over_squeeze.plot(
            squeeze[closing][touching], grasp.force[closing][touching], color=_OBJECT_COLORS[name], lw=1.4
        )
    over_time.set(title="(d) squeeze [mm]", xlabel="time since the fingers began to close [s]", ylim=(0, None))
    over_time.legend(frameon=False)
    over_squeeze.set(title="(e) normal force of a finger [N], as the grip grows", xlabel="squeeze [mm]")
    over_squeeze.set(xlim=(0, None), ylim=(0, None))


def main(stem: Path = Path("results/soft_grasps")) -> None:
    """Prints and draws all grasps."""
    grasps = {name: run_grasp(name) for name in OBJECTS}
    print("object    modulus  force  squeeze  largest strain  slip  placed within")
    for name, grasp in grasps.items():
        result = grasp.result
        print(
            f"{name:<9} {1e-3 * grasp.modulus:3.0f} kPa {result.peak_force_n:5.2f} N {result.squeeze_mm:5.2f} mm"
            f" {100 * grasp.strain.max():12.1f} % {result.slip_mm:5.1f} mm {result.placed_error_mm:8.1f} mm"
        )
    stem.parent.mkdir(parents=True, exist_ok=True)
    save_figure(soft_figure(grasps), stem)


if __name__ == "__main__":
    main()
