"""Draws the figures of docs/verification.md."""

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from kirchhoff_rod import finger_tip
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator
from published_rods import Release, published_releases, published_shapes, released_tips, rod, shape_errors
from pushed_fingers import compliance, with_cloth

from soft_gripper.pictures.rendering import SceneRenderer, framing_camera
from soft_gripper.pictures.style import STYLE
from studies import ROOT
from studies.verification.grasps import GRASPS, PUSH_TIME, GraspRun
from studies.verification.tables import RODS, shipped_finger

DOCS = ROOT / "docs"
BLUE, RED, GREY = "#2166ac", "#b2182b", "#7f7f7f"
LINKS = (6, 12, 24, 48)
SHOWN_TIME = 3.0  # s, of a release
VIEW = np.array([0.75, 1.0, -0.75])  # onto fingers from one side and above, so that what is out of their plane is seen
PICTURE_PIXELS = 460  # pixels


def _save(figure: Figure, name: str) -> None:
    figure.savefig(DOCS / f"{name}.png", dpi=150)


def draw_rods() -> bool:
    """Draws errors of shapes at rest against the number of links, and a motion; False: there are no solutions."""
    shapes, releases = {name: published_shapes(name) for name in RODS}, published_releases("tpu")
    if not releases or None in shapes.values():
        return False
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 3.6), layout="constrained")
        static_axes, moving_axes = figure.subplots(1, 2, width_ratios=(1, 1.6))
        for name, color, marker in zip(RODS, (RED, BLUE), "os", strict=True):
            errors = [100 * shape_errors(rod(name, links), shapes[name]).mean() for links in LINKS]
            static_axes.plot(LINKS, errors, color=color, marker=marker, ms=5, lw=1.5, label=name.replace("tpu", "TPU"))
        static_axes.plot(LINKS, 0.9 * (6 / np.array(LINKS)) ** 2, "--", color=GREY, lw=1, label="second order")
        static_axes.axhline(0.025, color=GREY, lw=0.8, ls=":")
        static_axes.annotate("the files are rounded", (6, 0.0255), color=GREY, fontsize="small", va="bottom")
        static_axes.set(xscale="log", yscale="log", xlabel="links", ylabel="mean error of the tip [% of the length]")
        static_axes.set_title("250 shapes at rest", loc="left")
        static_axes.xaxis.set_major_locator(FixedLocator(LINKS))
        static_axes.xaxis.set_minor_locator(NullLocator())
        static_axes.yaxis.set_major_locator(FixedLocator((0.02, 0.05, 0.1, 0.2, 0.5, 1)))
        static_axes.yaxis.set_minor_locator(NullLocator())
        for axis in (static_axes.xaxis, static_axes.yaxis):
            axis.set_major_formatter("{x:g}")
        static_axes.legend(frameon=False)
        _draw_release(moving_axes, releases[0])
        _save(figure, "verification_rods")
    return True


def _draw_release(axes: Axes, release: Release) -> None:
    is_shown = release.time <= SHOWN_TIME
    own_tips = released_tips(rod("tpu", 24, release.relaxation_time), release._replace(time=release.time[is_shown]))
    for axis, (color, name) in enumerate(zip((RED, BLUE, GREY), "xyz", strict=True)):
        axes.plot(release.time[is_shown], 1e3 * release.tips[is_shown, axis], color=color, lw=4.5, alpha=0.3)
        axes.plot(release.time[is_shown], 1e3 * own_tips[:, axis], color=color, lw=1, label=name)
    axes.set(xlabel="time [s]", ylabel="tip [mm]", xlim=(0, SHOWN_TIME))
    axes.set_title("A rod of TPU is released: Cosserat rod (wide lines), 24 links (thin)", loc="left")
    axes.legend(frameon=False, ncols=3, loc="lower right")


def draw_compliance() -> None:
    """Draws the compliance of the shipped finger at its tip against pressure: sideways and in its plane."""
    finger, pressures = shipped_finger(), np.linspace(0, 150e3, 16)
    lines = {
        "sideways, layer of cloth": (with_cloth(finger), 1, RED, "--"),
        "sideways, layer of film": (finger, 1, RED, "-"),
        "in its plane": (finger, 0, BLUE, "-"),
    }
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 3.6), layout="constrained")
        axes = figure.subplots()
        for name, (curve_finger, direction, color, dashes) in lines.items():
            values = [compliance(curve_finger, pressure, direction) for pressure in pressures]
            axes.plot(pressures / 1e3, values, color=color, ls=dashes, lw=1.6, label=name)
            for number, pressure in enumerate(pressures[::5]):
                force = 0.1 * np.eye(3)[direction]
                deflection = finger_tip(curve_finger, pressure, force) - finger_tip(curve_finger, pressure)
                label = "the same of a Kirchhoff rod" if number == 0 and name == "in its plane" else None
                axes.plot(
                    pressure / 1e3, 1e4 * deflection[direction], "o", color="0.2", ms=4.5, mfc="none", label=label
                )
        axes.axhline(0, color=GREY, lw=1.6, label="sideways, planar fingers")
        axes.set(xlabel="pressure [kPa]", ylabel="compliance of the tip [mm/N]", xlim=(-2, 152), ylim=(-4, 100))
        axes.legend(frameon=False, loc="upper left")
        _save(figure, "verification_compliance")


def draw_grasps(runs: Mapping[tuple[str, bool], GraspRun]) -> None:
    """Draws every object in the air, before its push; runs are by the grasp's name and whether fingers are spatial."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.1 * len(GRASPS), 4.75), layout="constrained")
        panels = figure.subplots(2, len(GRASPS))
        for row, is_spatial in zip(panels, (False, True), strict=True):
            for axes, name in zip(row, GRASPS, strict=True):
                axes.imshow(_picture(runs[name, is_spatial]))
                axes.set(xticks=[], yticks=[])
                for side in axes.spines.values():
                    side.set_visible(False)
            row[0].set_ylabel("spatial fingers" if is_spatial else "planar fingers", fontsize="large")
        for axes, name in zip(panels[0], GRASPS, strict=True):
            axes.set_title(name.replace(", ", ",\n"))
        _save(figure, "verification_grasps")


def _picture(run: GraspRun) -> np.ndarray:
    renderer = SceneRenderer(run.scenario, run.recording, PICTURE_PIXELS, PICTURE_PIXELS)
    object_name = run.scenario.models[-1].name
    middle = renderer.scene.object_position(object_name, PUSH_TIME)
    box_corners = np.array([[x, y, z] for x in (-0.04, 0.04) for y in (-0.03, 0.03) for z in (-0.03, 0.055)])
    return renderer.render(PUSH_TIME, framing_camera(middle + box_corners, PICTURE_PIXELS, PICTURE_PIXELS, VIEW))
