"""EstimateVisualizer: draws the estimates of the fingers in Meshcat, and into its recording.

The estimate is drawn along its joints, with straight links. Its uncertainty is a translucent ribbon on both sides of
the finger, with one piece per link. It extends two standard deviations to either side, averaged over the ends of the
link. The base pose is known.

The estimated contact force of a finger is an arrow that starts at the loaded face, at the estimated contact location,
and points in the direction of the force. That of a finger in its bending plane is drawn on both sides: next to the
finger, neither the finger nor the touched object can hide it.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatCone, Rgba
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, EventStatus, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.finger_drawing import (
    BAND_SIGNAL,
    STDS,
    Contact,
    arc_frames,
    arcs_of_table,
    contact_arrow,
    estimated_contact,
    estimated_corners,
    frames_along,
    is_in_space,
    link_frames,
)
from soft_gripper.diagrams.view.torque_colors import link_colors
from soft_gripper.estimators.arcs import Arcs
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points

PROUD = 1e-3  # m, protrusion of the estimate from the sides of the finger
_SIDE_SIGNS = {"left": 1, "right": -1}  # of the bending plane, with the sign of y


@dataclass(frozen=True, eq=False)
class DrawnFinger:
    """A finger whose estimate is drawn."""

    name: str
    finger: Finger
    sections: int  # arcs of the estimated curve
    base: BodyIndex  # body whose frame is B
    skin: tuple[tuple[str, ...], ...]  # Meshcat paths of the shapes of each link, base to tip
    signals: Mapping[str, int] = field(default_factory=dict)  # sizes of its `drawn_signals`

    @property
    def sides(self) -> tuple[float, float]:
        """Distances from the bending plane, m: the inner and outer bounds of the estimate drawn on each side.

        Nothing is drawn in between: the curve runs just below the inner face, which would hide it.
        """
        widths = [section.width for section in self.finger.cross_sections]
        return min(widths) / 2 - PROUD, max(widths) / 2 + PROUD


_ROUNDING_STEPS = 2.0**20  # per metre and per radian: rounded numbers, which compress well in an animation


def put(meshcat: Meshcat, path: str, position: Array, heading: float, time: float) -> None:
    """Poses an object in the frame above it, (x, z) m and rad from z to x.

    This takes less space in a recording than a transform.
    """
    x, z, angle = (rounded(value) for value in (*position, heading))
    meshcat.SetProperty(path, "position", [x, 0.0, z], time)
    meshcat.SetProperty(path, "rotation[y]", angle, time)


def _pose(meshcat: Meshcat, path: str, position: Array, R: RotationMatrix, time: float) -> None:
    """Poses an object in the frame above it, at a position, (3) m."""
    meshcat.SetTransform(path, RigidTransform(R, [rounded(value) for value in position]), time)


def rounded(value: float) -> float:
    """Rounds a length, m, or an angle, rad, to about 1e-6."""
    return round(float(value) * _ROUNDING_STEPS) / _ROUNDING_STEPS


def unit_circle() -> Array:
    """A circle of radius 1 m about y, (3, 97) corners."""
    angle = np.linspace(0, 2 * np.pi, 97)
    return np.array([np.sin(angle), np.zeros_like(angle), np.cos(angle)])


BAND = "/drake/estimate/band"
BAND_COLOR = Rgba(0.0, 0.6, 0.6, 0.45)
_MIN_WIDTH = 1e-6  # m; Meshcat has no shape without width


def place_ribbon(meshcat: Meshcat, drawn: DrawnFinger) -> None:
    """Makes the pieces, 1 m wide. They protrude less than the curve, which covers them."""
    inside, outside = drawn.sides
    _place_pieces(meshcat, BAND, drawn, (1.0, outside - PROUD / 2 - inside), 1.03, BAND_COLOR)


def _place_pieces(
    meshcat: Meshcat, group: str, drawn: DrawnFinger, size: tuple[float, float], stretch: float, rgba: Rgba
) -> None:
    """Makes a box of size (x, y) m on either side of every link; `stretch` is box length over link length."""
    for i, length in enumerate(stretch * np.diff(drawn.finger.link_ends)):
        for side, sign in _SIDE_SIGNS.items():
            path = f"{group}/{drawn.name}/{i}/{side}"
            meshcat.SetObject(path, Box(*size, length), rgba)
            meshcat.SetProperty(path, "position", [0.0, sign * (drawn.sides[0] + size[1] / 2), 0.0])


def widen_ribbon(meshcat: Meshcat, drawn: DrawnFinger, std: Array, time: float) -> None:
    """Scales the pieces by the standard deviations of joints and tip, (N + 1) m; hides unknown ones."""
    ends = np.concatenate([[0.0], std])
    link_std = (ends[:-1] + ends[1:]) / 2  # m, at mid-link
    for i, width in enumerate(2 * STDS * link_std):
        for side in _SIDE_SIGNS:
            path = f"{BAND}/{drawn.name}/{i}/{side}"
            meshcat.SetProperty(path, "visible", bool(np.isfinite(width)), time)
            if np.isfinite(width):
                meshcat.SetProperty(path, "scale", [max(rounded(width), _MIN_WIDTH), 1.0, 1.0], time)


CONTACT = "/drake/estimate/contact"
ARROW_COLOR = Rgba(1.0, 0.72, 0.0)
_SHAFT_RADIUS, _HEAD_LENGTH, _HEAD_RADIUS = 0.9e-3, 5e-3, 2.2e-3  # m


def place_arrow(meshcat: Meshcat, drawn: DrawnFinger) -> None:
    """Makes the arrow, hidden: along z from the origin, with a shaft of 1 m that is scaled later."""
    path = _arrow_path(drawn)
    offset = drawn.sides[1] + PROUD
    R_flip = RotationMatrix.MakeXRotation(np.pi)  # a cone in Meshcat has its apex at the origin
    for side, y in [("middle", 0.0)] if is_in_space(drawn.signals) else [("left", offset), ("right", -offset)]:
        meshcat.SetObject(f"{path}/shaft/{side}", Cylinder(_SHAFT_RADIUS, 1.0), ARROW_COLOR)
        meshcat.SetTransform(f"{path}/shaft/{side}", RigidTransform([0.0, y, 0.5]))
        meshcat.SetObject(f"{path}/head/{side}", MeshcatCone(_HEAD_LENGTH, _HEAD_RADIUS, _HEAD_RADIUS), ARROW_COLOR)
        meshcat.SetTransform(f"{path}/head/{side}", RigidTransform(R_flip, [0.0, y, _HEAD_LENGTH]))
    meshcat.SetProperty(path, "visible", False)


def draw_links(meshcat: Meshcat, path: str, corners: Array, time: float) -> None:
    """Poses a piece for every link between corners, (N + 2, 3) m in B; hides unknown links."""
    middles = (corners[:-1] + corners[1:]) / 2
    for i, (middle, R) in enumerate(zip(middles, link_frames(corners), strict=True)):
        is_known = bool(np.isfinite(R).all())
        meshcat.SetProperty(f"{path}/{i}", "visible", is_known, time)
        if is_known:
            _pose(meshcat, f"{path}/{i}", middle, RotationMatrix(R), time)


def draw_arrow(meshcat: Meshcat, drawn: DrawnFinger, corners: Array, contact: Contact, time: float) -> None:
    """Poses the arrow of a contact where the surface is pressed; hides it where that is not known."""
    path = _arrow_path(drawn)
    ends = contact_arrow(drawn.finger, corners, contact)
    meshcat.SetProperty(path, "visible", ends is not None, time)
    if ends is not None:
        begin = ends[0]
        shaft = ends[1] - ends[0]
        _pose(meshcat, path, begin, RotationMatrix(frames_along(shaft)), time)
        length = rounded(max(float(np.linalg.norm(shaft)) - _HEAD_LENGTH, 0.0))
        meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, length], time)
        meshcat.SetProperty(f"{path}/head", "position", [0.0, 0.0, length], time)


def _arrow_path(drawn: DrawnFinger) -> str:
    return f"{CONTACT}/{drawn.name}/arrow"


CURVE, ARCS = "/drake/estimate/curve", "/drake/estimate/arcs"
_CURVE_COLOR = Rgba(0.05, 0.05, 0.05)
_ARC_COLOR = Rgba(0.0, 0.35, 0.15)
_MAX_RADIUS = 1.0  # m; a flatter arc is not drawn


class EstimateVisualizer(LeafSystem):
    """Shows the estimates of each finger in Meshcat, and in its recording.

    ::

        body_poses ------------------------> +--------------------+
        {finger}.arcs (S x 7) -------------> |                    |
        {finger}.external_torque (N) ------> | EstimateVisualizer | ~~~> Meshcat
        {finger}, joints and tip ----------> |                    |
        {finger}.contact_force (1) N ------> |                    |
        {finger}.contact_arc_length (1) m -> |                    |
        {finger}.position_std (N + 1) m ---> +--------------------+

    Joints and tip are `joint_positions` (N x 2) m and `tip_pose` (3) in the bending plane, or, of an estimate in
    space, `estimated_joint_positions` (N x 3) and `estimated_tip_position` (3) m in B; its contact is
    `contact_force_vector` (3) N in B, `contact_arc_length` and `contact_side` (1) rad.

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
            for name, size in finger.signals.items():
                self.DeclareVectorInputPort(f"{finger.name}.{name}", size)
        self.DeclareInitializationPublishEvent(self._place_objects)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._publish)
        self.DeclareForcedPublishEvent(self._publish)

    def _place_objects(self, context: Context) -> EventStatus:
        self._meshcat.Delete("/drake/estimate")
        self._meshcat.SetProperty(ARCS, "visible", False)
        for finger in self.fingers:
            inside, outside = finger.sides
            _place_pieces(self._meshcat, CURVE, finger, (2 * PROUD, outside - inside), 1.1, _CURVE_COLOR)
            for i in range(finger.sections):
                # A circle of radius 1 m in the bending plane, and two radii along +z
                path = f"{ARCS}/{finger.name}/{i}/unit"
                self._meshcat.SetLine(f"{path}/circle", unit_circle(), 1.0, _ARC_COLOR)
                for radius in ("begin", "end"):
                    self._meshcat.SetLine(f"{path}/{radius}", np.array([[0, 0], [0, 0], [0, 1]]), 2.0, _ARC_COLOR)
            if "contact_arc_length" in finger.signals:
                place_arrow(self._meshcat, finger)
            if BAND_SIGNAL in finger.signals:
                place_ribbon(self._meshcat, finger)
        return EventStatus.Succeeded()

    def _publish(self, context: Context) -> EventStatus:
        time = context.get_time()
        poses = self._body_poses.Eval(context)
        for finger in self.fingers:
            for group in (CURVE, ARCS, CONTACT, BAND):
                self._meshcat.SetTransform(f"{group}/{finger.name}", poses[finger.base], time)
            arcs = arcs_of_table(self._signal(context, finger, "arcs").reshape(-1, 7))
            self._draw_arcs(finger, arcs, time)
            self._color_skin(finger, self._signal(context, finger, "external_torque"), time)
            signals = {name: self._signal(context, finger, name) for name in finger.signals}
            corners = estimated_corners(signals)
            draw_links(self._meshcat, f"{CURVE}/{finger.name}", corners, time)
            if (contact := estimated_contact(signals, corners)) is not None:
                draw_arrow(self._meshcat, finger, corners, contact, time)
            if BAND_SIGNAL in signals:
                draw_links(self._meshcat, f"{BAND}/{finger.name}", corners, time)
                widen_ribbon(self._meshcat, finger, signals[BAND_SIGNAL], time)
        return EventStatus.Succeeded()

    def _signal(self, context: Context, finger: DrawnFinger, name: str) -> Array:
        return self.GetInputPort(f"{finger.name}.{name}").Eval(context)

    def _draw_arcs(self, finger: DrawnFinger, arcs: Arcs, time: float) -> None:
        centers, headings, radii = arc_frames(arcs)
        for i, radius in enumerate(radii):
            path = f"{ARCS}/{finger.name}/{i}"
            is_drawn = bool(radius < _MAX_RADIUS)  # False if NaN
            self._meshcat.SetProperty(path, "visible", is_drawn, time)
            if is_drawn:
                put(self._meshcat, path, as_points(centers[i]), headings[i], time)
                self._meshcat.SetProperty(f"{path}/unit", "scale", [radius, 1.0, radius], time)
                self._meshcat.SetProperty(f"{path}/unit/end", "rotation[y]", float(arcs.theta[i]), time)

    def _color_skin(self, finger: DrawnFinger, torque: Array, time: float) -> None:
        colors = _linear(link_colors(torque, self._limit)).tolist()
        for paths, rgb in zip(finger.skin, colors, strict=True):
            for path in paths:
                for channel, value in zip("rgb", rgb, strict=True):
                    self._meshcat.SetProperty(f"{path}/<object>", f"material.color[{channel}]", value, time)


def _linear(srgb: Array) -> Array:
    """Converts sRGB colours to the linear intensities that Meshcat's materials use."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
