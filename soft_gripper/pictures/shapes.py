"""Fig. 4 of the paper: the shape of one finger, simulated and estimated, in its bending plane."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.view.estimate_shapes import arcs_of_table, point_at
from soft_gripper.diagrams.view.torque_colors import add_torque_bar, color
from soft_gripper.estimators.arcs import Arcs
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar
from soft_gripper.pictures.finger_shapes import (
    ESTIMATED_COLOR,
    TRUE_COLOR,
    Arrow,
    arrow_of_force,
    draw_arcs,
    draw_band,
    draw_base,
    draw_force,
    draw_segments,
    draw_tube,
    in_mm,
    point_on_links,
)
from soft_gripper.pictures.torque_bar import torque_limit
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, corners

STYLE: dict[Any, Any] = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
TITLES = ("(a) simulation", "(b) estimated arcs", "(c) estimate")
WIDTH = 8.4  # inches
_TRUE_WIDTH = 2.4  # points, so that the estimated force does not hide the true one


class Shape(NamedTuple):
    """What a recording says about one finger at one time, in B."""

    corners: Array  # (N + 2, 3) m, the true base, joints and tip
    arcs: Arcs
    joints: Planar  # (N) m, estimated
    torque: Array  # (N) N m, estimated
    true_torque: Array  # (N) N m
    pose_error: float  # m
    true_contact: Arrow | None
    contact: Arrow | None  # estimated, if it is
    std: Array | None  # (N + 1) m, of the estimated joints and tip across the finger, if it is estimated


def read_shape(layout: MeasurementModel, recording: Recording, time: float) -> Shape:
    """The shape of the finger of `layout`, which was recorded with these sensors, at a time, s."""
    name, now = layout.finger.name, recording.data.sel(time=time, method="nearest")
    signals = {str(kind).removeprefix(f"{name}."): signal.values for kind, signal in now.data_vars.items()}
    true = corners(signals[TRUE_JOINTS], signals[TRUE_TIP])
    arcs = arcs_of_table(signals["arcs"])
    return Shape(
        true,
        arcs,
        as_planar(signals["joint_positions"]),
        signals["external_torque"],
        signals["true_external_torque"],
        float(signals["pose_error"].item()),
        _arrow(layout.finger, partial(point_on_links, layout.finger, true), signals, "true_contact"),
        _arrow(layout.finger, partial(point_at, arcs), signals, "contact"),
        signals.get("position_std"),
    )


def _arrow(
    finger: Finger, point_at: Callable[[float], tuple[complex, float]], signals: Mapping[str, Array], which: str
) -> Arrow | None:
    """The arrow of the true or the estimated contact; None if there is none, or it is not recorded."""
    if f"{which}_force" not in signals:
        return None
    force, s = (float(signals[f"{which}_{name}"].item()) for name in ("force", "arc_length"))
    return arrow_of_force(finger, *point_at(s), force, s) if np.isfinite(s) else None


def shape_figure(layout: MeasurementModel, recording: Recording, time: float) -> Figure:
    """Three panels at a time, s: the simulation, the estimated arcs over the true joints, the estimate.

    The contact force is drawn where it presses, 25 mm a newton: the true one, and beside it the estimated one where the
    estimator has one, as the uncertainty of the curve.

    Drawn in frame B, mm, with the base at the top. Segments and arcs have the colours of the true and of
    the estimated external torque, on one scale; the numbers at the arcs are their radii.
    """
    finger, shape = layout.finger, read_shape(layout, recording, time)
    arcs = len(shape.arcs.theta)
    if arcs != layout.sections:  # an estimator may have an arc a segment
        layout = replace(layout, sections=arcs, borders=None)
    limit = torque_limit([shape.torque, shape.true_torque])
    x_limits, z_limits = _limits(layout, shape)
    widths = [float(np.ptp(limits)) for limits in x_limits]
    height = 1.3 + (WIDTH - 2.2) * float(np.ptp(z_limits)) / sum(widths)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, min(max(height, 3.2), 4.2)), layout="compressed")
        panels = figure.subplots(1, 3, sharey=True, width_ratios=widths)
        draw_segments(panels[0], finger, shape.corners, color(shape.true_torque, limit))
        draw_segments(panels[1], finger, shape.corners, np.full((finger.segments, 3), 0.94))
        draw_arcs(panels[1], layout, shape.arcs)
        _draw_joints(panels[1], shape)
        draw_tube(panels[2], layout, shape.arcs, color(shape.torque, limit))
        _draw_contact(panels, finger, shape)
        for axes, limits, title in zip(panels, x_limits, TITLES, strict=True):
            draw_base(axes, finger)
            axes.set(title=title, xlabel="x [mm]", aspect="equal", xlim=limits, ylim=z_limits)
        panels[0].set_ylabel("z [mm]")
        bar = add_torque_bar(figure, limit, ax=panels, aspect=30)
        bar.ax.yaxis.label.set_fontsize("small")
        figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure


def _limits(layout: MeasurementModel, shape: Shape) -> tuple[list[Array], Array]:
    """Of x in the three panels and of z, mm; the centres of arcs are shown if they lie near."""
    x, z = 1e3 * shape.corners[:, ::2].T
    free = 1e3 * layout.finger.base.thickness
    outer, inner = (1e3 * float(face) for face in (layout.finger.base.outer_face, layout.finger.base.inner_face))
    arrows = [arrow for arrow in (shape.true_contact, shape.contact) if arrow is not None]
    tips = [1e3 * arrow.end.imag for arrow in arrows]
    finger = np.array([min([min(x) + outer, *tips]) - free / 2, max([max(x) + inner, *tips]) + free / 2])
    centers = in_mm(shape.arcs.centers)[:, 0]
    near = centers[np.abs(centers - np.mean(x)) < 1e3 * layout.finger.length]
    with_centers = np.array([min([finger[0] - free, *(near - 5)]), max([finger[1] + free, *(near + 5)])])
    return [finger, with_centers, finger], np.array([max(*z + free, 0.9e3 * layout.finger.length), -0.7 * free])


def _draw_contact(panels: Sequence[Axes], finger: Finger, shape: Shape) -> None:
    """The true force in the first and the last panel, and what is estimated in the last."""
    if shape.std is not None:
        draw_band(panels[2], finger, shape.arcs, shape.std)
    if shape.true_contact is not None:
        draw_force(panels[0], shape.true_contact, TRUE_COLOR, "true contact force", _TRUE_WIDTH)
    if shape.contact is not None:
        draw_force(panels[2], shape.contact, ESTIMATED_COLOR, "estimated contact force")
        if shape.true_contact is not None:
            draw_force(panels[2], shape.true_contact, TRUE_COLOR, "_true, beside it", _TRUE_WIDTH)


def _draw_joints(axes: Axes, shape: Shape) -> None:
    estimated = f"estimated joints (mean error {1e3 * shape.pose_error:.2f} mm)"
    axes.plot(*(1e3 * shape.corners[1:-1, ::2].T), "o", ms=5.5, mfc="white", mec="black", mew=0.9, label="true joints")
    axes.plot(*in_mm(shape.joints).T, ".", ms=4, color="black", label=estimated)
    axes.plot([], [], lw=0.8, ls=(0, (4, 2)), color="0.4", label="radii [mm] from the centres of the arcs")
