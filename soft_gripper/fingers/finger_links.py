"""A finger as plain URDF: links, joints and spring-damper pairs, as XML elements.

A segment has a joint for each deformation, all in one place, and links between them. These have a millionth of a
finger link's mass, since cenic rejects massless bodies.
"""

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.files.xml_text import DRAKE
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_parts import AXES, SLIDES

_SILICONE_COLOR = "0.93 0.55 0.36 1"
_JOINT_LINK_MASS_SHARE = 1e-6  # mass of a link between two joints of a segment, over that of the link before
_KNUCKLE_WIDTH_RATIO = 0.994  # width of a knuckle over that of its link
_STEEL_DENSITY = 7850.0  # kg/m^3
_STEEL_COLOR = "0.6 0.62 0.65 1"
SPRINGS = ("linear", "torsion", "implicit")
_SKIN_LINKS = 12  # segments of a finger whose skin has the stiffness of its modulus
_FINEST_SKIN = 24  # maximum of segments with a piece of skin each; with more, several share a piece
# The row of points of the last link, and its share of the stiffness. A tip that presses on something leans on its end,
# over a wedge that covers about half of this link; chosen by the force and the tip of the box grasp (docs/solver.md).
_TIP_ROW, _TIP_SHARE = 0.6, 0.5
_PAD_RADIUS = 2e-3  # m, maximum
_CONTACT_FREE_PIECES = 2  # pieces of skin up to this distance apart never touch


def link_name(finger: str, index: int) -> str:
    """Name of a link: 0 is fixed to the parent, N ends at the tip."""
    return f"{finger}_link_{index}"


def joint_name(finger: str, index: int, deformation: str = "bending") -> str:
    """Name of the joint of a segment, 0 to N - 1 from the base, for one deformation."""
    return f"{finger}_{'joint' if deformation == 'bending' else deformation}_{index}"


def tip_name(finger: str) -> str:
    return f"{finger}_tip"


class _Joint(NamedTuple):
    finger: Finger
    segment: int
    deformation: str
    parent: str  # links
    child: str
    height: float  # m, along the parent

    @property
    def name(self) -> str:
        return joint_name(self.finger.name, self.segment, self.deformation)

    @property
    def slides(self) -> bool:
        return self.deformation in SLIDES

    @property
    def stiffness(self) -> float:
        """N m/rad, or N/m where it slides."""
        return float(self.finger.stiffnesses[self.deformation][self.segment])

    @property
    def damping(self) -> float:
        """N m s/rad, or N s/m where it slides."""
        return self.finger.relaxation_time * self.stiffness


def _joints(finger: Finger) -> list[_Joint]:
    joints: list[_Joint] = []
    for i in range(finger.segments):
        deformations = finger.deformations(i)
        inner_links = [f"{finger.name}_{deformation}_link_{i}" for deformation in deformations[:-1]]
        links = [link_name(finger.name, i), *inner_links, link_name(finger.name, i + 1)]
        heights = [finger.segment_length / (1 if i else 2), *[0.0] * len(inner_links)]
        columns = deformations, links[:-1], links[1:], heights
        joints += [_Joint(finger, i, *joint) for joint in zip(*columns, strict=True)]
    return joints


def finger_to_urdf(
    mounted: FingerElement,
    springs: str = "linear",
    visuals: bool = True,
    points: int | None = None,
    touches_itself: bool = False,
) -> list[ET.Element]:
    """The URDF elements of a finger, from base to tip.

    The frame of link 0 is frame B; the frame of every other link sits at the joint before it. A frame named
    `{finger}_tip` marks the end. Without `visuals`, it is invisible. With `points`, that many spheres on either side of
    every link touch other bodies, instead of its surface. If it `touches_itself`, links more than two apart do.

    Springs are "linear" force elements; or actuators that hold every joint where it is straight, which Drake's discrete
    plant solves together with its contacts, "implicit". With "torsion", joints that turn are limp, see
    `add_torsion_springs`.
    """
    finger = mounted.finger
    links = [_link(finger, i, visuals, points) for i in range(finger.segments + 1)]
    joints = _joints(finger)
    joint_links: list[ET.Element] = []  # nearly massless
    for joint in joints:
        if joint.child != link_name(finger.name, joint.segment + 1):
            mass = _JOINT_LINK_MASS_SHARE * float(finger.link_masses[joint.segment])
            inertial = _inertial(mass, (0, 0), (mass * finger.segment_length**2,) * 3)
            joint_links.append(_element("link", inertial, name=joint.child))
    is_implicit = springs == "implicit"
    spring_joints = [joint for joint in joints if springs == "linear" or (springs == "torsion" and joint.slides)]
    elastic = [spring for joint in spring_joints for spring in _springs(joint)]
    driven_joints = [joint for joint in joints if is_implicit or joint.deformation in finger.driven_deformations]
    actuators = [_actuator(joint, is_implicit) for joint in driven_joints]
    hinges = [_hinge(joint, 0.0 if is_implicit else joint.damping) for joint in joints]
    mount_name, base = f"{finger.name}_mount", link_name(finger.name, 0)
    mount_pose = {"xyz": _text(*mounted.xyz), "rpy": _text(*mounted.rpy)}
    mount = _joint(mount_name, "fixed", mounted.parent, base, mount_pose)
    last_link, xyz = link_name(finger.name, finger.segments), _text(0, 0, finger.segment_length / 2)
    tip = _element("frame", name=tip_name(finger.name), link=last_link, xyz=xyz, rpy="0 0 0")
    filters = _collision_filters(finger, touches_itself)
    return [*links, mount, *joint_links, *hinges, *elastic, *actuators, tip, *filters]


def _element(tag: str, /, *children: ET.Element, **attributes: str) -> ET.Element:
    element = ET.Element(tag, attributes)
    element.extend(children)
    return element


def _text(*values: float) -> str:
    return " ".join(f"{v:.15g}" for v in values)


def _link(finger: Finger, index: int, visuals: bool, points: int | None) -> ET.Element:
    links = finger.links
    mass = float(links.mass[index])
    x, y, z = mass * links.gyration[:, index]
    moments = (y + z, x + z, x + y)
    return _element(
        "link",
        _inertial(mass, links.center[:, index].tolist(), moments, -mass * float(links.product[index])),
        *(_visuals(finger, index) if visuals else []),
        *_skin(finger, index, points),
        name=link_name(finger.name, index),
    )


def _visuals(finger: Finger, index: int) -> list[ET.Element]:
    block = _Block.from_links(finger, index, index)
    elements = [_element("visual", *block.box(), _material(finger))]
    if index:
        elements += _knuckles(finger, block.width, block.begin)
    if (load := finger.tip_load) is not None and index == finger.segments:  # a steel ball with its mass
        radius = (load.mass / (4 / 3 * np.pi * _STEEL_DENSITY)) ** (1 / 3)
        origin = _element("origin", xyz=_text(load.x, 0, block.length + load.z))
        ball = _element("geometry", _element("sphere", radius=_text(radius)))
        steel = _element("material", _element("color", rgba=_STEEL_COLOR), name="steel")
        elements.append(_element("visual", origin, ball, steel))
    return elements


class _Block(NamedTuple):
    begin: float  # m, arc lengths of its ends
    end: float
    thickness: float  # m
    width: float
    middle: float  # m, of the thickness, from the neutral axis

    @classmethod
    def from_links(cls, finger: Finger, first: int, last: int) -> "_Block":
        begin, end = float(finger.link_ends[first]), float(finger.link_ends[last + 1])
        section = finger.section(np.array((begin + end) / 2))
        return cls(begin, end, float(section.thickness), float(section.width), -float(section.neutral_axis))

    @property
    def length(self) -> float:
        return self.end - self.begin

    @property
    def thinnest(self) -> float:
        """Smallest side of the block, m."""
        return min(self.thickness, self.width, self.length)

    def box(self, origin: float | None = None) -> tuple[ET.Element, ET.Element]:
        """XML elements of the origin and the geometry, in a frame at an arc length, m; None: where the block begins."""
        height = (0.0 if origin is None else self.begin - origin) + self.length / 2
        size = _text(self.thickness, self.width, self.length)
        return _element("origin", xyz=_text(self.middle, 0, height)), _element("geometry", _element("box", size=size))


def _inertial(mass: float, center: Sequence[float], moments: tuple[float, ...], ixz: float = 0.0) -> ET.Element:
    x, z = center
    ixx, iyy, izz = map(_text, moments)
    inertia = _element("inertia", ixx=ixx, iyy=iyy, izz=izz, ixy="0", ixz=_text(ixz), iyz="0")
    return _element("inertial", _element("origin", xyz=_text(x, 0, z)), _element("mass", value=_text(mass)), inertia)


def _knuckles(finger: Finger, width: float, s: float) -> list[ET.Element]:
    """Visual cylinders at a joint, across the section: they fill the wedge that opens at the outer side.

    One is as thick as the section; where it would protrude at the base or the tip, several are thinner, and overlap.
    They are hardly narrower than the link: a step shows as a line, and surfaces that coincide flicker.
    """
    section, room = finger.section(s), min(s, finger.length - s)
    half = float(section.thickness) / 2
    radius = half / math.ceil(half / room)
    middles = np.linspace(radius - half, half - radius, 2 * round(half / radius) - 1) - section.neutral_axis
    size = {"radius": _text(radius), "length": _text(_KNUCKLE_WIDTH_RATIO * width)}
    geometry, rpy = _element("geometry", _element("cylinder", **size)), _text(np.pi / 2, 0, 0)
    origins = [_element("origin", xyz=_text(x, 0, 0), rpy=rpy) for x in middles]
    return [_element("visual", origin, geometry, _material(finger)) for origin in origins]


def _material(finger: Finger) -> ET.Element:
    return _element("material", _element("color", rgba=_SILICONE_COLOR), name=f"{finger.name}_skin")


def _skin(finger: Finger, index: int, points: int | None) -> list[ET.Element]:
    """The collision geometry of a link: a piece of the skin, which may extend over its neighbours, or none.

    The pressure in a hydroelastic box is its modulus times the depth over half its smallest side, so that with an equal
    modulus, shorter boxes would be stiffer; and those of a very fine chain would be pressed to their middles.
    """
    pieces = np.arange(finger.segments + 1.0)  # number of the piece of skin of each link
    if finger.segments > _FINEST_SKIN:
        middles = (finger.link_ends[:-1] + finger.link_ends[1:]) / 2
        pieces = np.round(_FINEST_SKIN * middles / finger.length + 1e-9)
    links = np.flatnonzero(pieces == pieces[index])
    if index != (links[len(links) // 2] if links[0] else 0):  # only link 0 may touch what the finger is mounted on
        return []
    block, origin = _Block.from_links(finger, links[0], links[-1]), float(finger.link_ends[index])
    is_end, usual_side = pieces[index] in (pieces[0], pieces[-1]), finger.length / _SKIN_LINKS
    usual_side = min(block.thickness, block.width, usual_side / 2 if is_end else usual_side)
    modulus = finger.contact.hydroelastic_modulus * block.thinnest / usual_side
    if points is None:
        hint = _element(DRAKE + "mesh_resolution_hint", value=_text(finger.thinnest.thickness / 2))
        surface = hint, _element(DRAKE + "hydroelastic_modulus", value=f"{modulus:.12g}")
        properties = _proximity(finger, _element(DRAKE + "compliant_hydroelastic"), *surface)
        return [_element("collision", *block.box(origin), properties)]
    return _pads(finger, block, origin, modulus, points)


def _proximity(finger: Finger, *stiffness: ET.Element) -> ET.Element:
    contact = finger.contact
    return _element(
        DRAKE + "proximity_properties",
        *stiffness,
        _element(DRAKE + "hunt_crossley_dissipation", value=_text(contact.dissipation)),
        _element(DRAKE + "mu_static", value=_text(contact.friction)),
        _element(DRAKE + "mu_dynamic", value=_text(contact.friction)),
    )


def _pads(finger: Finger, block: _Block, origin: float, modulus: float, points: int) -> list[ET.Element]:
    """Spheres under the skin on the inner and the outer side of a block, that many on each, in a row across its middle.

    Together they are as stiff as the surface: the pressure of a hydroelastic box is the modulus E times the depth over
    H, half its smallest side, so all points of a side of area A have the stiffness E A / H. The frame is at the arc
    length `origin`, m.
    """
    radius, width = min(_PAD_RADIUS, block.thickness / 5), block.width
    row, stiffness_fraction = (_TIP_ROW, _TIP_SHARE) if block.end == finger.length else (0.5, 1.0)
    stiffness = stiffness_fraction * modulus * width * block.length / (block.thinnest / 2) / points
    offset, height = block.thickness / 2 - radius, block.begin - origin + row * block.length
    y_positions = ((np.arange(points) + 0.5) / points - 0.5) * width
    places = [(block.middle + side * offset, y, height) for side in (1, -1) for y in y_positions.tolist()]
    sphere = _element("geometry", _element("sphere", radius=_text(radius)))
    touch = _proximity(finger, _element(DRAKE + "point_contact_stiffness", value=_text(stiffness)))
    return [_element("collision", _element("origin", xyz=_text(*place)), sphere, touch) for place in places]


def _hinge(joint: _Joint, damping: float) -> ET.Element:
    kind, origin = "prismatic" if joint.slides else "continuous", {"xyz": _text(0, 0, joint.height)}
    element = _joint(joint.name, kind, joint.parent, joint.child, origin)
    ET.SubElement(element, "axis", xyz=_text(*AXES[joint.deformation]))
    ET.SubElement(element, "dynamics", damping=_text(damping))
    return element


def _joint(name: str, kind: str, parent: str, child: str, origin: dict[str, str]) -> ET.Element:
    links = _element("parent", link=parent), _element("child", link=child)
    return _element("joint", *links, _element("origin", **origin), name=name, type=kind)


def _springs(joint: _Joint) -> list[ET.Element]:
    """Lists the springs of a joint: linear if it slides, almost linear if it turns.

    A spring along the slide is attached a finger's length away, out of reach.

    The two springs of a bending joint run from -h on one link to +h on the next, at +-d to the sides. Their torque at
    the angle t is 4 k sin(t/2) (h^2 (1 - cos(t/2)) + d^2 cos(t/2)). With d = sqrt(3)/2 h the cubic term vanishes and
    the pair is a linear torsion spring of stiffness 2 k d^2.

    One spring through the joint, which presses the links apart since its free length is L, has the torque
    k h^2 sin(t) (L / (2 h cos(t/2)) - 1). With L = 8 h that is the same function of the angle, of stiffness 3 k h^2, at
    half the cost. The joints beside those of bending have it; these stay free of its thrust.
    """
    finger = joint.finger
    origin = np.array([0.0, 0.0, joint.height])
    h = joint.finger.segment_length / 2
    if joint.slides:
        far_end = origin - finger.length * np.array(AXES[joint.deformation])
        return [_spring(joint, far_end, np.zeros(3), finger.length, joint.stiffness)]
    if joint.deformation == "bending":
        offset, side = np.array([0.0, 0.0, h]), np.array([np.sqrt(3) / 2 * h, 0.0, 0.0])
        stiffness = joint.stiffness / (2 * side[0] ** 2)
        return [_spring(joint, origin - offset + d, offset + d, 2 * h, stiffness) for d in (side, -side)]
    offset = np.array([0.0, 0.0, h] if joint.deformation == "sideways" else [h, 0.0, 0.0])
    return [_spring(joint, origin - offset, offset, 8 * h, joint.stiffness / (3 * h**2))]


def _spring(joint: _Joint, p_AP: Array, p_BQ: Array, free_length: float, stiffness: float) -> ET.Element:
    tag = DRAKE + "linear_spring_damper"
    body_A = _element(f"{tag}_body_A", name=joint.parent), _element(f"{tag}_p_AP", value=_text(*p_AP))
    body_B = _element(f"{tag}_body_B", name=joint.child), _element(f"{tag}_p_BQ", value=_text(*p_BQ))
    numbers = {"free_length": _text(free_length), "stiffness": _text(stiffness), "damping": "0"}
    law = (_element(f"{tag}_{name}", value=value) for name, value in numbers.items())
    return _element(tag, *body_A, *body_B, *law)


def _actuator(joint: _Joint, is_spring: bool) -> ET.Element:
    """Actuator for the torque of the pressure; cenic integrates actuation twice as fast as applied forces.

    As a spring it also has stiffness and damping of the joint, as gains of a PD controller.
    """
    transmission, interface = ET.Element("transmission", name=f"{joint.name}_transmission"), "hardwareInterface"
    ET.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
    for tag in ("joint", "actuator"):
        end = ET.SubElement(transmission, tag, name=joint.name)
        ET.SubElement(end, interface).text = "hardware_interface/EffortJointInterface"
    if is_spring:
        ET.SubElement(end, DRAKE + "controller_gains", p=_text(joint.stiffness), d=_text(joint.damping))
    return transmission


def _collision_filters(finger: Finger, touches_itself: bool) -> list[ET.Element]:
    """Filters contacts of links, or of those near each other: neighbours overlap on the inner side of a bend."""
    links = [link_name(finger.name, i) for i in range(finger.segments + 1)]
    free_links = _CONTACT_FREE_PIECES * math.ceil(finger.segments / _FINEST_SKIN)
    distance, groups = free_links if touches_itself else finger.segments, []
    for i in range(max(len(links) - distance, 1)):
        name = f"{finger.name}_links_{i}"
        members = [_element(DRAKE + "member", link=link) for link in links[i : i + distance + 1]]
        ignored = _element(DRAKE + "ignored_collision_filter_group", name=name)
        groups.append(_element(DRAKE + "collision_filter_group", *members, ignored, name=name))
    return groups
