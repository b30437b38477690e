"""EstimateVisualizer: draws the estimates of the fingers in Meshcat, and into its recording.

The uncertainty of an estimated curve is a translucent ribbon on both sides of the finger, with one piece per link. It
extends two standard deviations to either side, averaged over the ends of the link. The base pose is known.

The estimated contact force of a finger is an arrow on both sides of the finger. It starts at
the loaded face, at the estimated contact location, and points in the direction of the force. Next to the finger,
neither the finger nor the touched object can hide it.

An estimate in space is drawn along its joints, with straight links; the arrow of its force begins where the surface is
pressed, which may be on any side, so that there is one.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatCone, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, EventStatus, LeafSystem

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.view.links_in_space import link_frames, pressed_point
from soft_gripper.diagrams.view.torque_colors import color
from soft_gripper.estimators.arcs import Arcs, join_arcs, points_on_arcs, sites_on_arcs
from soft_gripper.estimators.contact import face_offset
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points

PROUD = 1e-3  # m, how far the estimate protrudes from the sides of the finger
_PIECES = 2  # of the curve, per segment
PLACES = "estimated_joint_positions", "estimated_tip_position"  # signals of an estimate in space
CONTACT_SIGNALS = {
    False: ("contact_force", "contact_arc_length"),
    True: ("contact_force_vector", "contact_arc_length", "contact_side"),
}


@dataclass(frozen=True, eq=False)
class DrawnFinger:
    """A finger whose estimate is drawn."""

    name: str
    finger: Finger
    section_ends: NDArray[np.int_]  # segments covered up to the end of each arc of the estimated curve, from 0 to N
    base: BodyIndex  # body whose frame is B
    skin: tuple[tuple[str, ...], ...]  # Meshcat paths of the shapes of each link, base to tip
    has_contact: bool = False  # a contact force is estimated
    has_band: bool = False  # the uncertainty of the curve is estimated
    in_space: bool = False  # the estimate is one in space

    @property
    def contact_signals(self) -> tuple[str, ...]:
        """Names of the signals that say what presses where."""
        return CONTACT_SIGNALS[self.in_space]

    @property
    def sections(self) -> int:
        """Number of arcs of the estimated curve."""
        return len(self.section_ends) - 1

    @property
    def pieces(self) -> int:
        """Number of pieces in which each arc of the curve is drawn, in the plane."""
        return int(np.ceil(_PIECES * self.finger.segments / self.sections))

    @property
    def piece_lengths(self) -> Array:
        """Length of each piece, m; in space a piece is a link."""
        if self.in_space:
            return np.diff(self.finger.link_ends)
        sections = np.diff(self.section_ends) * self.finger.segment_length
        return np.repeat(sections / self.pieces, self.pieces)

    @property
    def sides(self) -> tuple[float, float]:
        """Distances from the bending plane, m: the inner and outer bounds of the estimate drawn on each side.

        Nothing is drawn in between: the curve runs just below the inner face, which would hide it.
        """
        widths = [section.width for section in self.finger.cross_sections]
        return min(widths) / 2 - PROUD, max(widths) / 2 + PROUD


_STEPS = 2.0**20  # per metre and per radian: rounded numbers, which compress well in an animation


def put(meshcat: Meshcat, path: str, position: Array, heading: float, time: float) -> None:
    """Poses an object in the frame above it, (x, z) m and rad from z to x.

    This takes less space in a recording than a transform.
    """
    x, z, angle = (rounded(value) for value in (*position, heading))
    meshcat.SetProperty(path, "position", [x, 0.0, z], time)
    meshcat.SetProperty(path, "rotation[y]", angle, time)


def rounded(value: float) -> float:
    """Rounds a length, m, or an angle, rad, to about 1e-6."""
    return round(float(value) * _STEPS) / _STEPS


def arcs_of_table(table: Array) -> Arcs:
    """The arcs in a reshaped `arcs` port of an estimator, (S, 7)."""
    _, _, _, kappa, length, _, _ = table.T
    return join_arcs(kappa * length, length)


def curve_pieces(arcs: Arcs, pieces: int) -> tuple[Planar, Array]:
    """Midpoints (m in B) and headings (rad) of the chords of the equal `pieces` of each arc, (S * pieces).

    Unknown pieces coincide with the last known one, so that the curve ends there.
    """
    sections, ends = np.arange(len(arcs.theta)), np.linspace(0, 1, pieces + 1)
    points = points_on_arcs(arcs, np.repeat(sections, pieces + 1), np.tile(ends, len(sections)))
    points = points.reshape(len(sections), pieces + 1)
    middles = (points[:, :-1] + points[:, 1:]) / 2
    headings = arcs.heading[:, None] + arcs.theta[:, None] * (ends[:-1] + ends[1:]) / 2
    known = np.isfinite(headings.ravel())
    last = np.maximum.accumulate(np.where(known, np.arange(known.size), 0))
    return np.nan_to_num(middles.ravel()[last]), np.nan_to_num(headings.ravel()[last])


def arc_frames(arcs: Arcs) -> tuple[Planar, Array, Array]:
    """Centres (m in B) of the arcs, headings (rad) of the radii to their starting points, and radii (m), each (S)."""
    headings = arcs.heading - np.sign(arcs.theta) * np.pi / 2
    return arcs.centers, headings, np.abs(arcs.start - arcs.centers)


def unit_circle(edges: int = 96) -> Array:
    """A circle of radius 1 m about y, (3, edges + 1) corners."""
    angle = np.linspace(0, 2 * np.pi, edges + 1)
    return np.array([np.sin(angle), np.zeros_like(angle), np.cos(angle)])


BAND = "/drake/estimate/band"
STDS = 2  # standard deviations on either side
BAND_COLOR = Rgba(0.0, 0.6, 0.6, 0.45)
_LEAST = 1e-6  # m; Meshcat has no shape without width


def place_ribbon(meshcat: Meshcat, drawn: DrawnFinger) -> None:
    """Makes the pieces, 1 m wide."""
    inside, outside = drawn.sides
    thickness = outside - inside - PROUD / 2  # protrudes less than the curve, which covers it
    for i, length in enumerate(np.diff(drawn.finger.link_ends)):
        for side, sign in (("left", 1), ("right", -1)):
            path = f"{_ribbon_path(drawn, i)}/{side}"
            meshcat.SetObject(path, Box(1.0, thickness, 1.03 * length), BAND_COLOR)
            meshcat.SetProperty(path, "position", [0.0, sign * (inside + thickness / 2), 0.0])


def draw_ribbon(meshcat: Meshcat, drawn: DrawnFinger, arcs: Arcs, std: Array, time: float) -> None:
    """Places and scales the pieces by the standard deviations of joints and tip, (N + 1) m; hides unknown ones."""
    ends, widths = drawn.finger.link_ends, 2 * STDS * _in_links(std)
    middles, headings = sites_on_arcs(arcs, (ends[:-1] + ends[1:]) / 2)
    for i, (middle, heading, width) in enumerate(zip(as_points(middles), headings, widths, strict=True)):
        path, visible = _ribbon_path(drawn, i), bool(np.isfinite([*middle, heading, width]).all())
        meshcat.SetProperty(path, "visible", visible, time)
        if visible:
            put(meshcat, path, middle, heading, time)
            meshcat.SetProperty(path, "scale", [max(rounded(width), _LEAST), 1.0, 1.0], time)


def _in_links(std: Array) -> Array:
    """At the midpoints of the links, (N + 1)."""
    ends = np.concatenate([[0.0], std])
    return (ends[:-1] + ends[1:]) / 2


def _ribbon_path(drawn: DrawnFinger, link: int) -> str:
    return f"{BAND}/{drawn.name}/{link}"


CONTACT = "/drake/estimate/contact"
LENGTH = 0.025  # m/N, as for the true forces
LEAST = 0.02  # N, smallest force drawn, as for the true forces
ARROW_COLOR = Rgba(1.0, 0.72, 0.0)
_RADIUS, _HEAD, _HEAD_RADIUS = 0.9e-3, 5e-3, 2.2e-3  # m


def place_arrow(meshcat: Meshcat, drawn: DrawnFinger) -> None:
    """Makes the arrow, hidden: along z from the origin, with a shaft of 1 m that is scaled later."""
    path, aside = _arrow_path(drawn), drawn.sides[1] + PROUD
    turned = RotationMatrix.MakeXRotation(np.pi)  # a cone in Meshcat has its apex at the origin
    for side, y in [("middle", 0.0)] if drawn.in_space else [("left", aside), ("right", -aside)]:
        meshcat.SetObject(f"{path}/shaft/{side}", Cylinder(_RADIUS, 1.0), ARROW_COLOR)
        meshcat.SetTransform(f"{path}/shaft/{side}", RigidTransform([0.0, y, 0.5]))
        meshcat.SetObject(f"{path}/head/{side}", MeshcatCone(_HEAD, _HEAD_RADIUS, _HEAD_RADIUS), ARROW_COLOR)
        meshcat.SetTransform(f"{path}/head/{side}", RigidTransform(turned, [0.0, y, _HEAD]))
    meshcat.SetProperty(path, "visible", False)


def draw_arrow(meshcat: Meshcat, drawn: DrawnFinger, arcs: Arcs, force: float, arc_length: float, time: float) -> None:
    """Poses the arrow of a force, N, that presses at an arc length, m; hides it where either is not known."""
    path, s, side = _arrow_path(drawn), np.array([arc_length]), np.sign(force)
    begins, (heading,) = sites_on_arcs(arcs, s, face_offset(drawn.finger, s, side))
    (begin,) = as_points(begins)
    visible = bool(abs(force) >= LEAST and np.isfinite([*begin, heading]).all())  # not if it is NaN
    meshcat.SetProperty(path, "visible", visible, time)
    if visible:
        length = max(LENGTH * abs(force) - _HEAD, 0.0)
        put(meshcat, path, begin, heading - side * np.pi / 2, time)
        meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, rounded(length)], time)
        meshcat.SetProperty(f"{path}/head", "position", [0.0, 0.0, rounded(length)], time)


def draw_links(meshcat: Meshcat, path: str, corners: Array, time: float) -> None:
    """Poses a piece for every link between corners, (N + 2, 3) m in B; hides those that are not known."""
    middles = (corners[:-1] + corners[1:]) / 2
    for i, (middle, R) in enumerate(zip(middles, link_frames(corners), strict=True)):
        known = bool(np.isfinite(R).all())
        meshcat.SetProperty(f"{path}/{i}", "visible", known, time)
        if known:
            meshcat.SetTransform(f"{path}/{i}", RigidTransform(RotationMatrix(R), middle), time)


def widen_links(meshcat: Meshcat, path: str, std: Array, time: float) -> None:
    """Scales the pieces of a ribbon in space by the standard deviations of joints and tip, (N + 1) m."""
    for i, width in enumerate(2 * STDS * _in_links(std)):
        for side in ("left", "right"):
            scale = max(rounded(width), _LEAST) if np.isfinite(width) else _LEAST
            meshcat.SetProperty(f"{path}/{i}/{side}", "scale", [scale, 1.0, 1.0], time)


def draw_arrow_in_space(
    meshcat: Meshcat, drawn: DrawnFinger, corners: Array, force: Array, arc_length: float, side: float, time: float
) -> None:
    """Poses the arrow of a force, (3) N in B, where the surface is pressed; hides it where that is not known."""
    path, size = _arrow_path(drawn), float(np.linalg.norm(force))
    known = bool(size >= LEAST and np.isfinite([*corners.ravel(), arc_length, side]).all())  # not if it is NaN
    meshcat.SetProperty(path, "visible", known, time)
    if known:
        R = RotationMatrix.MakeFromOneVector(force / size, 2)
        meshcat.SetTransform(path, RigidTransform(R, pressed_point(drawn.finger, corners, arc_length, side)), time)
        length = rounded(max(LENGTH * size - _HEAD, 0.0))
        meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, length], time)
        meshcat.SetProperty(f"{path}/head", "position", [0.0, 0.0, length], time)


def _arrow_path(drawn: DrawnFinger) -> str:
    return f"{CONTACT}/{drawn.name}/arrow"


CURVE, ARCS = "/drake/estimate/curve", "/drake/estimate/arcs"
_CURVE_COLOR = Rgba(0.05, 0.05, 0.05)
_ARC_COLOR = Rgba(0.0, 0.35, 0.15)
_LARGEST_RADIUS = 1.0  # m; a flatter arc is not drawn


class EstimateVisualizer(LeafSystem):
    """Shows the estimates of each finger in Meshcat, and in its recording.

    ::

        body_poses ------------------------> +--------------------+
        {finger}.arcs (S x 7) -------------> |                    |
        {finger}.external_torque (N) ------> | EstimateVisualizer | ~~~> Meshcat
        {finger}.contact_force (1) N ------> |                    |
        {finger}.contact_arc_length (1) m -> |                    |
        {finger}.position_std (N + 1) m ---> +--------------------+

    An estimate in space has `estimated_joint_positions` (N x 3) m and `estimated_tip_position` (3) m in B as well, and
    its contact `contact_force_vector` (3) N in B, `contact_arc_length` and `contact_side` (1) rad instead.

    The links of the finger are coloured by the external torque, N m, on a scale that ends at
    `torque_limit`. The estimated curve is a dark line that protrudes from both sides of the finger. The circles and
    radii of its arcs are hidden until `estimate/arcs` is ticked in Meshcat's tree. Where a sensor has failed,
    the curve ends and the links are dark grey. Contact and uncertainty are inputs if they are estimated: the force is
    an arrow, and the uncertainty of the curve a translucent ribbon.
    """

    def __init__(self, meshcat: Meshcat, fingers: Sequence[DrawnFinger], torque_limit: float, period: float):
        super().__init__()
        self._meshcat, self.fingers, self._limit = meshcat, tuple(fingers), torque_limit
        self._body_poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        for finger in self.fingers:
            self.DeclareVectorInputPort(f"{finger.name}.arcs", finger.sections * 7)
            self.DeclareVectorInputPort(f"{finger.name}.external_torque", finger.finger.segments)
            for name, size in zip(PLACES, (3 * finger.finger.segments, 3), strict=True) if finger.in_space else ():
                self.DeclareVectorInputPort(f"{finger.name}.{name}", size)
            for name in finger.contact_signals if finger.has_contact else ():
                self.DeclareVectorInputPort(f"{finger.name}.{name}", 3 if name.endswith("vector") else 1)
            if finger.has_band:
                self.DeclareVectorInputPort(f"{finger.name}.position_std", finger.finger.segments + 1)
        self.DeclareInitializationPublishEvent(self._place_objects)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    def _place_objects(self, context: Context) -> EventStatus:
        self._meshcat.Delete("/drake/estimate")
        self._meshcat.SetProperty(ARCS, "visible", False)
        for finger in self.fingers:
            inside, outside = finger.sides
            for i, length in enumerate(1.1 * finger.piece_lengths):
                box = Box(2 * PROUD, outside - inside, length)
                for side, y in (("left", (inside + outside) / 2), ("right", -(inside + outside) / 2)):
                    path = f"{CURVE}/{finger.name}/{i}/{side}"
                    self._meshcat.SetObject(path, box, _CURVE_COLOR)
                    self._meshcat.SetProperty(path, "position", [0.0, y, 0.0])
            for i in range(finger.sections):
                self._place_arc(f"{ARCS}/{finger.name}/{i}/unit")
            if finger.has_contact:
                place_arrow(self._meshcat, finger)
            if finger.has_band:
                place_ribbon(self._meshcat, finger)
        return EventStatus.Succeeded()

    def _place_arc(self, path: str) -> None:
        """A circle of radius 1 m in the bending plane, and two radii along +z."""
        self._meshcat.SetLine(f"{path}/circle", unit_circle(), 1.0, _ARC_COLOR)
        for radius in ("begin", "end"):
            self._meshcat.SetLine(f"{path}/{radius}", np.array([[0, 0], [0, 0], [0, 1]]), 2.0, _ARC_COLOR)

    def _publish(self, context: Context) -> EventStatus:
        time, poses = context.get_time(), self._body_poses.Eval(context)
        for finger in self.fingers:
            for group in (CURVE, ARCS, *[CONTACT] * finger.has_contact, *[BAND] * finger.has_band):
                self._meshcat.SetTransform(f"{group}/{finger.name}", poses[finger.base], time)
            arcs = arcs_of_table(self._signal(context, finger, "arcs").reshape(-1, 7))
            self._draw_arcs(finger, arcs, time)
            self._color_skin(finger, self._signal(context, finger, "external_torque"), time)
            if finger.in_space:
                self._draw_in_space(context, finger, time)
                continue
            self._draw_curve(finger, arcs, time)
            if finger.has_contact:
                (force,), (place,) = (self._signal(context, finger, name) for name in finger.contact_signals)
                draw_arrow(self._meshcat, finger, arcs, force, place, time)
            if finger.has_band:
                draw_ribbon(self._meshcat, finger, arcs, self._signal(context, finger, "position_std"), time)
        return EventStatus.Succeeded()

    def _draw_in_space(self, context: Context, finger: DrawnFinger, time: float) -> None:
        corners = np.concatenate([np.zeros(3), *(self._signal(context, finger, name) for name in PLACES)]).reshape(
            -1, 3
        )
        draw_links(self._meshcat, f"{CURVE}/{finger.name}", corners, time)
        if finger.has_contact:
            force, (place,), (side,) = (self._signal(context, finger, name) for name in finger.contact_signals)
            draw_arrow_in_space(self._meshcat, finger, corners, force, place, side, time)
        if finger.has_band:
            draw_links(self._meshcat, f"{BAND}/{finger.name}", corners, time)
            widen_links(self._meshcat, f"{BAND}/{finger.name}", self._signal(context, finger, "position_std"), time)

    def _signal(self, context: Context, finger: DrawnFinger, name: str) -> Array:
        value: Array = self.GetInputPort(f"{finger.name}.{name}").Eval(context)
        return value

    def _draw_curve(self, finger: DrawnFinger, arcs: Arcs, time: float) -> None:
        middles, headings = curve_pieces(arcs, finger.pieces)
        for i, (middle, heading) in enumerate(zip(as_points(middles), headings, strict=True)):
            put(self._meshcat, f"{CURVE}/{finger.name}/{i}", middle, heading, time)

    def _draw_arcs(self, finger: DrawnFinger, arcs: Arcs, time: float) -> None:
        centers, headings, radii = arc_frames(arcs)
        for i, radius in enumerate(radii):
            path, drawn = f"{ARCS}/{finger.name}/{i}", bool(radius < _LARGEST_RADIUS)  # False if NaN
            self._meshcat.SetProperty(path, "visible", drawn, time)
            if drawn:
                put(self._meshcat, path, as_points(centers[i]), headings[i], time)
                self._meshcat.SetProperty(f"{path}/unit", "scale", [radius, 1.0, radius], time)
                self._meshcat.SetProperty(f"{path}/unit/end", "rotation[y]", float(arcs.theta[i]), time)

    def _color_skin(self, finger: DrawnFinger, torque: Array, time: float) -> None:
        """Colours each link by the torque at its proximal joint; the first link takes the colour of the second."""
        colors = _linear(color(np.concatenate([torque[:1], torque]), self._limit)).tolist()
        for paths, rgb in zip(finger.skin, colors, strict=True):
            for path in paths:
                for channel, value in zip("rgb", rgb, strict=True):
                    self._meshcat.SetProperty(f"{path}/<object>", f"material.color[{channel}]", value, time)


def _linear(srgb: Array) -> Array:
    """Converts sRGB colours to the linear intensities that Meshcat's materials use."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
