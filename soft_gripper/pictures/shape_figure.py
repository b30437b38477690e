"""Fig. 4 of the paper: the shape of one finger, simulated and estimated, in its bending plane.

A finger that leaves this plane is drawn from the side as well, and so is its estimate if it is one in space.
"""

from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import BoxStyle, FancyArrowPatch, FancyBboxPatch, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.view.finger_drawing import (
    BAND_SIGNAL,
    CONTACTS,
    STDS,
    arcs_of_table,
    arrow,
    contact_arrow,
    drawn_signals,
    estimated_contact,
    estimated_corners,
    is_in_space,
)
from soft_gripper.diagrams.view.torque_colors import add_torque_bar, color, torque_limit
from soft_gripper.estimators.arcs import Arcs, points_on_arcs
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, corners

SECTION_COLORS = ("#33608c", "#d1663b", "#3d8f5f", "#a9489c")
TRUE_COLOR, ESTIMATED_COLOR, BAND_COLOR = "#731a80", "#e09f00", "#009999"  # as in Meshcat, darker on white
_MAX_LABELLED_RADIUS = 10.0  # m; an arc with a larger radius is labelled straight
_TEXT_DISTANCE = 9e-3  # m, from the side of the finger to the label of its radius
_EDGE_COLOR = "0.35"
_FRONT_AXES, _SIDE_AXES = [0, 2], [1, 2]  # axes of B: as seen along y, and along x
_MIN_OFF_PLANE = 1e-4  # m, beyond which a finger is drawn from the side as well
STYLE: dict[Any, Any] = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False}
TITLES = ("(a) simulation", "(b) estimated arcs", "(c) estimate")
WIDTH = 8.4  # inches
_TRUE_WIDTH = 2.4  # points, so that the estimated force does not hide the true one


def to_mm(planar: Planar) -> Array:
    """(x, z) in mm, (..., 2), of points in m."""
    return 1e3 * as_points(planar)


def draw_base(axes: Axes, finger: Finger, aside: bool = False) -> None:
    """The mount of the finger, as a dark block; with `aside` seen along x."""
    width = 1.8e3 * (finger.base.width if aside else finger.base.thickness)
    depth = 0.6e3 * finger.base.thickness
    middle = 0.0 if aside else -1e3 * float(finger.base.neutral_axis)
    axes.add_patch(Rectangle((middle - width / 2, -depth), width, depth, color="#474f5c"))


def draw_segments(axes: Axes, finger: Finger, corners: Array, colors: Array, aside: bool = False) -> None:
    """The segments as rounded rectangles of `colors`, (N, 3), between base, joints and tip, (N + 2, 3) m in B.

    Seen along y, or with `aside` along x, foreshortened.
    """
    middles = (corners[1:-2] + corners[2:-1]) / 2  # of the links, where segments meet
    ends = 1e3 * np.concatenate([corners[:1], middles, corners[-1:]])[:, _SIDE_AXES if aside else _FRONT_AXES]
    section, full_length = finger.section(finger.joint_arc_lengths), 1e3 * finger.segment_length
    half = np.asarray(section.width) / 2
    faces = 1e3 * np.array([-half, half] if aside else [section.outer_face, section.inner_face]).T
    style = BoxStyle.Round(pad=0, rounding_size=0.2 * full_length)
    for (begin, end), (outer, inner), rgb in zip(pairwise(ends), faces, colors, strict=True):
        length = float(np.hypot(*(end - begin))) if aside else full_length
        segment = FancyBboxPatch(
            (outer, -length / 2), inner - outer, length, boxstyle=style, facecolor=rgb, edgecolor=_EDGE_COLOR, lw=0.6
        )
        place = Affine2D().rotate(-np.arctan2(*(end - begin))).translate(*(begin + end) / 2)
        segment.set_transform(place + axes.transData)
        axes.add_patch(segment)


def draw_tube(axes: Axes, layout: MeasurementModel, arcs: Arcs, colors: Array) -> None:
    """The finger bent along the arcs: a piece of `colors`, (N, 3), per segment, and an outline around each section."""
    section_index = np.arange(layout.finger.segments) - layout.section_ends[layout.joint_sections]
    for section, i, rgb in zip(layout.joint_sections, section_index, colors, strict=True):
        ends = np.array([i, i + 1]) / layout.joints_per_section[section]
        piece = _outline(layout, arcs, section, *ends)
        axes.add_patch(Polygon(piece, facecolor=rgb, edgecolor=rgb, lw=0.6))
    for section in range(layout.sections):
        axes.add_patch(Polygon(_outline(layout, arcs, section), fill=False, edgecolor=_EDGE_COLOR, lw=0.8))


def _outline(layout: MeasurementModel, arcs: Arcs, section: int, begin: float = 0.0, end: float = 1.0) -> Array:
    """Outline of the finger from `begin` to `end`, fractions of an arc, (M, 2) mm."""
    fraction = np.linspace(begin, end, 17)
    s = layout.section_ends[section] * layout.finger.segment_length + fraction * layout.rest_lengths[section]
    built = layout.finger.section(s)
    sections = np.full(len(fraction), section)
    inner, outer = (points_on_arcs(arcs, sections, fraction, face) for face in (built.inner_face, built.outer_face))
    return to_mm(np.concatenate([inner, outer[::-1]]))


def draw_arcs(axes: Axes, layout: MeasurementModel, arcs: Arcs) -> None:
    """The arcs with their centres, and with the radii to both of their ends, in mm."""
    for section, (start, center, end) in enumerate(zip(arcs.start, arcs.centers, arcs.end, strict=True)):
        look: dict[str, Any] = {"color": SECTION_COLORS[section % len(SECTION_COLORS)]}
        fraction = np.linspace(0, 1, 31)
        curve = points_on_arcs(arcs, np.full(len(fraction), section), fraction)
        axes.plot(*to_mm(curve).T, lw=2.4, solid_capstyle="butt", **look)
        axes.plot(*to_mm(np.array([start, center, end])).T, lw=0.7, ls=(0, (4, 2)), **look)
        axes.plot(*to_mm(np.array([center])).T, "+", ms=7, **look)
        # The radius, mm, beside the middle of the arc on the outer side of the bend.
        base, radius = layout.finger.base, abs(start - center)
        offset = base.outer_face - _TEXT_DISTANCE if arcs.theta[section] > 0 else base.inner_face + _TEXT_DISTANCE
        ((x, z),) = to_mm(points_on_arcs(arcs, np.array([section]), np.array([0.5]), offset))
        text = f"{1e3 * radius:.0f}" if radius < _MAX_LABELLED_RADIUS else "straight"
        axes.text(x, z, text, ha="center", va="center", fontsize="small", **look)


def draw_force(axes: Axes, arrow: Array, color: str, label: str, width: float = 1.4) -> None:
    """An arrow, (2, 2) m, with its name for the legend; a narrower one lies over a wider one."""
    begin, end = (tuple(1e3 * point) for point in arrow)
    look: dict[str, Any] = {"arrowstyle": "-|>", "mutation_scale": 6 * width, "shrinkA": 0, "shrinkB": 0}
    axes.add_patch(FancyArrowPatch(begin, end, color=color, lw=width, zorder=5 + 1 / width, **look))
    axes.plot([], [], color=color, lw=width, marker=">", ms=4, label=label)


def draw_band(axes: Axes, points: Array, std: Array, label: str = "") -> None:
    """Two standard deviations on either side of the curve from base to tip, (N + 2, 2) m, of its N + 1 other points."""
    tangents = np.gradient(points, axis=0)
    normals = tangents[:, ::-1] * np.array([1.0, -1.0]) / np.linalg.norm(tangents, axis=-1, keepdims=True)
    offsets = STDS * np.concatenate([[0.0], std])[:, None] * normals
    outline = 1e3 * np.concatenate([points + offsets, (points - offsets)[::-1]])
    axes.add_patch(Polygon(outline, facecolor=BAND_COLOR, alpha=0.45, lw=0, zorder=4, label=label))
    axes.plot(*(1e3 * points).T, color="black", lw=0.8, zorder=4)


class Shown(NamedTuple):
    """A finger, simulated or estimated, at one time, in B."""

    corners: Array  # (N + 2, 3) m, base, joints and tip
    torque: Array  # (N) N m, external
    force: Array | None  # (2, 3) m, the arrow of its contact force, if there is one
    std: Array | None = None  # (N + 1) m, of the joints and the tip across the finger, if available


class Snapshot(NamedTuple):
    """One finger at one time of a recording, in B."""

    true: Shown
    estimate: Shown
    is_in_space: bool  # whether the estimate is, and not in the bending plane
    arcs: Arcs
    joints: Array  # (N, 2) x, z; m, estimated, as seen along y
    pose_error: float  # m


def read_snapshot(layout: MeasurementModel, recording: Recording, time: float) -> Snapshot:
    """The finger of `layout`, which was recorded with these sensors, at a time, s."""
    finger, now = layout.finger, recording.data.sel(time=time, method="nearest")
    signals = {str(kind).removeprefix(f"{finger.name}."): signal.values for kind, signal in now.data_vars.items()}
    true = corners(signals[TRUE_JOINTS], signals[TRUE_TIP])
    if leaves_plane(true):  # its force is drawn in space, at the centre of pressure
        true_force, force_W = None, signals.get("true_contact_force_world")
        if force_W is not None:
            R_BW, p_WB = signals["X_WB"][:, :3].T, signals["X_WB"][:, 3]
            true_force = arrow(R_BW @ (signals["contact_center"] - p_WB), R_BW @ force_W)
    else:
        true_signals = {name: signals[f"true_{name}"] for name in CONTACTS[1] if f"true_{name}" in signals}
        true_force = contact_arrow(finger, true, estimated_contact(true_signals, true))
    finger_signals = {name: signals[name] for name in drawn_signals(signals)}
    curve = estimated_corners(finger_signals)
    force = contact_arrow(finger, curve, estimated_contact(finger_signals, curve))
    return Snapshot(
        Shown(true, signals["true_external_torque"], true_force),
        Shown(curve, signals["external_torque"], force, finger_signals.get(BAND_SIGNAL)),
        is_in_space(finger_signals),
        arcs_of_table(signals["arcs"]),
        signals["joint_positions"],
        float(signals["pose_error"].item()),
    )


def leaves_plane(corners: Array) -> bool:
    """Whether a finger with these corners, (..., 3) m in B, is bent sideways."""
    return bool(np.abs(corners[..., 1]).max() > _MIN_OFF_PLANE)


def shape_figure(layout: MeasurementModel, recording: Recording, time: float) -> Figure:
    """Three panels at a time, s: the simulation, the estimated arcs over the true joints, the estimate.

    The true contact force is drawn at the contact, 25 mm/N; so are the estimated force and the uncertainty of the
    curve, if the estimator provides them. A finger that leaves its plane has a fourth panel, the simulation seen along
    x, and the true force is that in space; if the estimate is in space too, a fifth shows it from there.

    Drawn in frame B, mm, with the base at the top. Segments and arcs are coloured by the true and the
    estimated external torque, on one scale; the numbers at the arcs are their radii.
    """
    finger, snapshot = layout.finger, read_snapshot(layout, recording, time)
    arcs = len(snapshot.arcs.theta)
    if arcs != layout.sections:  # an estimator may have one arc per segment
        layout = replace(layout, sections=arcs, borders=None)
    true, estimate = snapshot.true, snapshot.estimate
    limit = torque_limit([estimate.torque, true.torque])
    x_limits, z_limits = _limits(layout, snapshot)
    side_panels = [("(d) simulation", true), ("(e) estimate", estimate)][: 1 + snapshot.is_in_space]
    side_panels = side_panels if leaves_plane(true.corners) else []
    drawn_points = [points for points in (true.corners, true.force, estimate.force) if points is not None]
    y, half = 1e3 * np.concatenate(drawn_points)[:, 1], 1e3 * finger.base.width
    y_limits = np.array([y.min() - half, y.max() + half])
    widths = [float(np.ptp(limits)) for limits in [*x_limits, *[y_limits] * len(side_panels)]]
    height = 1.3 + (WIDTH - 2.2) * float(np.ptp(z_limits)) / sum(widths) + 0.2 * bool(side_panels)
    highest = 4.5 if side_panels else 4.2
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, min(max(height, 3.2), highest)), layout="compressed")
        panels = figure.subplots(1, len(widths), sharey=True, width_ratios=widths)
        draw_segments(panels[0], finger, true.corners, color(true.torque, limit))
        draw_segments(panels[1], finger, true.corners, np.full((finger.segments, 3), 0.94))
        draw_arcs(panels[1], layout, snapshot.arcs)
        true_joints, error = 1e3 * true.corners[1:-1, _FRONT_AXES], 1e3 * snapshot.pose_error
        panels[1].plot(*true_joints.T, "o", ms=5.5, mfc="white", mec="black", mew=0.9, label="true joints")
        label = f"estimated joints (mean error {error:.2f} mm)"
        panels[1].plot(*(1e3 * snapshot.joints).T, ".", ms=4, color="black", label=label)
        panels[1].plot([], [], lw=0.8, ls=(0, (4, 2)), color="0.4", label="radii [mm] from the arc centres")
        if snapshot.is_in_space:
            draw_segments(panels[2], finger, estimate.corners, color(estimate.torque, limit))
        else:
            draw_tube(panels[2], layout, snapshot.arcs, color(estimate.torque, limit))
        _draw_load(panels[0], _FRONT_AXES, true.force)
        _draw_load(panels[2], _FRONT_AXES, None if estimate.force is None else true.force, estimate)
        for axes, limits, title in zip(panels, x_limits, TITLES, strict=False):
            draw_base(axes, finger)
            axes.set(title=title, xlabel="x [mm]", aspect="equal", xlim=limits, ylim=z_limits)
        for axes, (title, shape) in zip(panels[3:], side_panels, strict=True):
            draw_segments(axes, finger, shape.corners, color(shape.torque, limit), aside=True)
            draw_base(axes, finger, aside=True)
            _draw_load(axes, _SIDE_AXES, true.force, shape if shape is estimate else None, "_")
            axes.set(xlabel="y [mm]", aspect="equal", xlim=y_limits, ylim=z_limits)
            axes.set_title(title, fontsize="medium")
        panels[0].set_ylabel("z [mm]")
        bar = add_torque_bar(figure, limit, ax=panels, aspect=30)
        bar.ax.yaxis.label.set_fontsize("small")
        figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize="small")
    return figure


def _draw_load(
    axes: Axes, view: list[int], true: Array | None, estimate: Shown | None = None, hidden: str = ""
) -> None:
    """The arrow of the true force and, of an estimate, its force and uncertainty, as seen by two axes of B.

    The legend has what is in the first and third panels: names that begin with "_", as `hidden`, are not in it.
    """
    if estimate is not None and estimate.std is not None:
        draw_band(axes, estimate.corners[:, view], estimate.std, f"{hidden}± {STDS} standard deviations")
    if estimate is not None and estimate.force is not None:
        draw_force(axes, estimate.force[:, view], ESTIMATED_COLOR, f"{hidden}estimated contact force")
    if true is not None:
        prefix = hidden if estimate is None else "_"
        draw_force(axes, true[:, view], TRUE_COLOR, f"{prefix}true contact force", _TRUE_WIDTH)


def _limits(layout: MeasurementModel, snapshot: Snapshot) -> tuple[list[Array], Array]:
    """Limits of x in the three panels, and of z, mm; the centres of arcs are shown if they are near."""
    x, z = 1e3 * snapshot.true.corners[:, ::2].T
    margin = 1e3 * layout.finger.base.thickness
    outer, inner = (1e3 * float(face) for face in (layout.finger.base.outer_face, layout.finger.base.inner_face))
    tips = [1e3 * force[1, 0] for force in (snapshot.true.force, snapshot.estimate.force) if force is not None]
    finger = np.array([min([min(x) + outer, *tips]) - margin / 2, max([max(x) + inner, *tips]) + margin / 2])
    centers = to_mm(snapshot.arcs.centers)[:, 0]
    close = centers[np.abs(centers - np.mean(x)) < 1e3 * layout.finger.length]
    with_centers = np.array([min([finger[0] - margin, *(close - 5)]), max([finger[1] + margin, *(close + 5)])])
    return [finger, with_centers, finger], np.array([max(*z + margin, 0.9e3 * layout.finger.length), -0.7 * margin])
