"""How much of a flat face two kinds of fingers touch: with a chamber throughout, and in the first 40 % alone.

    python examples/pictures/conforming_grasp.py

runs the scenarios box_grasp, up to the same pressure, and conforming_grasp, and draws results/conforming_grasp.png.
"""

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from pydrake.geometry import Box, QueryObject, Role

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.pictures.rendering import RecordedScene
from soft_gripper.pictures.shape_figure import draw_base, draw_segments
from soft_gripper.pictures.style import STYLE, save_figure
from soft_gripper.runs.scores.poses import held_rows
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.truth.contact import TouchedLinks
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, corners

CONFORMING, SHIPPED = "conforming_grasp", "box_grasp"
BOX = "box"


@dataclass(frozen=True)
class Grasp:
    """Contacts of one finger in the steps of a scenario, at the end of each."""

    finger: Finger
    pressure: Array  # (steps) Pa
    area: Array  # (steps, N + 1) m^2 of each link
    force: Array  # (steps, N + 1) N across each link, positive on the inner side
    corners: Array  # (N + 2, 3) m in B, at the last step: base, joints, tip
    box: Array  # (4, 2) m in B, at the last step: the corners of its section in the bending plane, x and z


def scenarios() -> dict[str, Scenario]:
    """The grasp of the shipped fingers, at the pressures of that of the conforming ones, and this."""
    conforming = load_scenario(CONFORMING)
    steps = conforming.pressure.steps["all"]
    return {SHIPPED: load_scenario(SHIPPED, [f"pressure.steps.all={steps}"]), CONFORMING: conforming}


def run_grasp(scenario: Scenario) -> Grasp:
    """Simulates a scenario in which fingers hold a box; reads the grasp of the first finger."""
    station = make_private_station(scenario)
    return read_grasp(scenario, run_station(station))


def read_grasp(scenario: Scenario, recording: Recording) -> Grasp:
    """The grasp of a recorded scenario."""
    scene = RecordedScene(scenario, recording)
    last = held_rows(scenario, recording)[:, -1]
    finger = scene.fingers[0]
    times = recording["time"].values[last]
    area = np.array([contact_areas(finger, scene.query(time)) for time in times])
    signals = {
        name: recording[f"{finger.name}.{name}"].values[last] for name in ("link_normal_force", TRUE_JOINTS, TRUE_TIP)
    }
    return Grasp(
        finger.finger,
        np.array(scenario.pressure.steps["all"]),
        area,
        signals["link_normal_force"],
        corners(signals[TRUE_JOINTS][-1], signals[TRUE_TIP][-1]),
        _section_of_box(scene, finger, times[-1]),
    )


def contact_areas(finger: PlantFinger, query: QueryObject) -> Array:
    """Contact area of each link of a finger, (N + 1) m^2."""
    areas = np.zeros(len(finger.links))
    links_by_geometry = TouchedLinks.from_finger(finger).link_of
    surfaces, _ = query.ComputeContactSurfacesWithFallback(finger.plant.get_contact_surface_representation())
    for surface in surfaces:
        for geometry in (surface.id_M(), surface.id_N()):
            if (link := links_by_geometry.get(geometry.get_value())) is not None:
                areas[link] += surface.total_area()
    return areas


def _section_of_box(scene: RecordedScene, finger: PlantFinger, time: float) -> Array:
    (body,) = scene.plant.GetBodyIndices(scene.plant.GetModelInstanceByName(BOX))
    query = scene.query(time)
    inspector = scene.scene_graph.model_inspector()
    (geometry,) = inspector.GetGeometries(scene.plant.GetBodyFrameIdOrThrow(body), Role.kProximity)
    shape = inspector.GetShape(geometry)
    assert isinstance(shape, Box)
    x, _, z = shape.size() / 2
    X_BO = finger.X_WB.inverse() @ query.GetPoseInWorld(geometry)
    around = np.array([(-x, 0, -z), (x, 0, -z), (x, 0, z), (-x, 0, z)])
    return X_BO.multiply(around.T).T[:, ::2]


_GRASP_COLORS = {SHIPPED: "#8c8c8c", CONFORMING: "#0072b2"}
_GRASP_LABELS = {SHIPPED: "chamber throughout", CONFORMING: "chamber in the first 40 %"}
_HOLLOW_COLOR, _SOLID_COLOR, _BOX_COLOR, _FORCE_COLOR = "#e8936a", "#f8d9c6", "#9fb8d3", "#111111"
_MM_PER_N = 12.0  # of the arrows
_MIN_FORCE = 0.02  # N, smallest force drawn
_X_LIMITS, _Z_LIMITS = (-31.0, 42.0), (150.0, -14.0)  # mm, limits of the drawings


def conforming_figure(grasps: dict[str, Grasp]) -> Figure:
    """One finger of each grasp at its last step, and contact area and mean contact pressure in all steps."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9.6, 4.6), layout="constrained")
        panels = figure.subplot_mosaic([["a", "b", "area"], ["a", "b", "pressure"]], width_ratios=[1, 1, 1.35])
        for panel, name in zip("ab", grasps, strict=True):
            _draw_grasp(panels[panel], grasps[name])
            panels[panel].set_title(f"({panel}) {_GRASP_LABELS[name]}\n{_summary(grasps[name])}")
        panels["a"].set_ylabel("z [mm]")
        _draw_curves(panels["area"], grasps, {name: 1e6 * grasp.area.sum(axis=1) for name, grasp in grasps.items()})
        _draw_curves(panels["pressure"], grasps, {name: 1e-3 * mean_pressure(grasp) for name, grasp in grasps.items()})
        panels["area"].sharex(panels["pressure"])
        panels["pressure"].autoscale(axis="x")
        panels["area"].tick_params(labelbottom=False)
        panels["area"].set(title="(c) contact area of a finger [mm²]")
        panels["area"].legend(frameon=False)
        panels["pressure"].set(title="(d) mean contact pressure [kPa]", xlabel="pressure in the chamber [kPa]")
        figure.legend(*panels["b"].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return figure


def _summary(grasp: Grasp) -> str:
    pressure, force, area = 1e-3 * grasp.pressure[-1], grasp.force[-1].sum(), 1e6 * grasp.area[-1].sum()
    return f"{pressure:.0f} kPa: {force:.2f} N on {area:.0f} mm²"


def mean_pressure(grasp: Grasp) -> Array:
    """Force over area of the contact of a finger, (steps) Pa; NaN without contact."""
    area = grasp.area.sum(axis=1)
    return np.divide(grasp.force.sum(axis=1), area, out=np.full(area.shape, np.nan), where=area > 0)


def _draw_grasp(axes: Axes, grasp: Grasp) -> None:
    """The finger, the box, and the force of every link on it, in frame B with the base at the top."""
    finger = grasp.finger
    colors = np.array([to_rgb(_HOLLOW_COLOR if gain > 0 else _SOLID_COLOR) for gain in finger.pressure_gain])
    axes.add_patch(Polygon(1e3 * grasp.box, facecolor=_BOX_COLOR, edgecolor="0.35", lw=0.6))
    draw_base(axes, finger)
    draw_segments(axes, finger, grasp.corners, colors)
    middles = 1e3 * (grasp.corners[:-1, 2] + grasp.corners[1:, 2]) / 2
    face = 1e3 * grasp.box[:, 0].min()
    for z, force in zip(middles, grasp.force[-1], strict=True):
        if force > _MIN_FORCE:
            axes.annotate("", (face + _MM_PER_N * force, z), (face, z), arrowprops=_ARROW_STYLE)
    for color, label in ((_HOLLOW_COLOR, "with a chamber"), (_SOLID_COLOR, "solid, softer"), (_BOX_COLOR, "box")):
        axes.plot([], [], "s", color=color, mec="0.35", mew=0.6, ms=8, label=label)
    axes.plot([], [], color=_FORCE_COLOR, lw=1.2, marker=">", ms=4, label=f"force of a link, {_MM_PER_N:g} mm/N")
    axes.set(aspect="equal", xlim=_X_LIMITS, ylim=_Z_LIMITS, xlabel="x [mm]")


_ARROW_STYLE = {"arrowstyle": "-|>", "color": _FORCE_COLOR, "lw": 1.2, "mutation_scale": 8, "shrinkA": 0, "shrinkB": 0}


def _draw_curves(axes: Axes, grasps: dict[str, Grasp], curves: dict[str, Array]) -> None:
    for name, values in curves.items():
        axes.plot(
            grasps[name].pressure / 1e3,
            values,
            "o-",
            color=_GRASP_COLORS[name],
            ms=4,
            lw=1.5,
            label=_GRASP_LABELS[name],
        )
    axes.set_ylim(bottom=0)


def main(stem: Path = Path("results/conforming_grasp")) -> None:
    """Prints and draws both grasps."""
    grasps = {name: run_grasp(scenario) for name, scenario in scenarios().items()}
    for name, grasp in grasps.items():
        links = (grasp.area[-1] > 0).sum()
        pressure = 1e-3 * mean_pressure(grasp)[-1]
        print(f"{name}, {_summary(grasp)}, {pressure:.1f} kPa in the mean; links that touch: {links}")
    stem.parent.mkdir(parents=True, exist_ok=True)
    save_figure(conforming_figure(grasps), stem)


if __name__ == "__main__":
    main()
