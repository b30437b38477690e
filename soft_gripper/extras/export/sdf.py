"""A scenario as SDFormat: links, joints with their springs, and contact shapes, for Gazebo, Drake and others.

Every tree of bodies is a model of the world. SDFormat has no drive: the pressures are named among what is left out.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydrake.geometry import Box, Capsule, Convex, Cylinder, Ellipsoid, GeometryId, HalfSpace, Mesh, Shape, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.tree import Joint, RevoluteJoint, RigidBody, WeldJoint

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.extras.export.tree import (
    SOFT,
    axis_of,
    inertia_of,
    joints_below,
    left_out,
    pose_at_zero,
    springs,
    text,
)
from soft_gripper.scenario.schema import Scenario

_NO_MASS = 1e-9  # kg and kg m^2, of links without mass
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


class Sdf(NamedTuple):
    """A scenario as SDFormat."""

    text: str
    meshes: Mapping[str, Path]  # files that the text names, by their names in it
    left_out: Sequence[str]


def to_sdf(scenario: Scenario) -> Sdf:
    """A scenario as SDFormat.

    Raises:
        InputError: if a part of the scenario cannot be built, is soft, or has a joint or a shape without a counterpart.
    """
    station = make_station(scenario)
    for model in scenario.models:
        if model.name in station.parts.deformables:
            raise InputError("export", "models", model.name, SOFT)
    return _Writer(station).write()


class _Writer:
    """Writes one station."""

    def __init__(self, station: Station):
        self._station, self._plant = station, station.plant
        self._inspector = station.parts.scene_graph.model_inspector()
        self._children, self._springs = joints_below(self._plant), dict(springs(station.fingers))
        self._meshes: dict[str, Path] = {}

    def write(self) -> Sdf:
        root = ET.Element("sdf", version="1.9")
        world = ET.SubElement(root, "world", name="scenario")
        ET.SubElement(world, "gravity").text = text(self._station.scenario.gravity)
        for joint in self._children.get(self._plant.world_body().index(), []):
            model = ET.SubElement(world, "model", name=_name(joint.child_body()))
            self._add(model, joint, RigidTransform())
        self._add_world_shapes(world)
        ET.indent(root)
        lacks = [f"{finger.name}: pressures, SDFormat has no drive" for finger in self._station.fingers]
        lacks += [f"{finger.name}: creep" for finger in self._station.fingers if finger.finger.creep]
        skin = "hydroelastic_modulus of its skin; contacts are those of the other simulator"
        lacks += [f"{finger.name}: {skin}" for finger in self._station.fingers]
        lacks += ["contacts between links of one model, such as two fingers, in simulators that leave them out"]
        for name, mimics in self._station.parts.mimics.items():
            lacks += [f"{name}: joint {mimic.joint} follows {mimic.leader}; it moves freely" for mimic in mimics]
        begun = [each.name for each in self._station.scenario.models if each.initial_position]
        lacks += [f"{name}: initial_position, joints begin at 0" for name in begun]
        if self._station.scenario.directives:
            lacks.append("directives: default_joint_positions, joints begin at 0")
        if self._station.scenario.arm is not None:
            lacks += ["arm: its posture where a run begins, and its controllers"]
        return Sdf(ET.tostring(root, encoding="unicode") + "\n", self._meshes, [*lacks, *left_out(self._station)])

    def _add(self, model: ET.Element, joint: Joint, X_WP: RigidTransform) -> None:
        """Adds the child of a joint, and all below it, in the zero posture."""
        body, X_WC = joint.child_body(), X_WP @ pose_at_zero(joint)
        link = ET.SubElement(model, "link", name=_name(body))
        _pose(link, X_WC)
        self._add_inertia(link, body)
        for geometry in self._plant.GetCollisionGeometriesForBody(body):
            self._add_shape(link, geometry, self._inspector.GetPoseInFrame(geometry))
        if not body.is_floating_base_body():
            self._add_joint(model, joint)
        for below in self._children.get(body.index(), []):
            self._add(model, below, X_WC)

    def _add_world_shapes(self, world: ET.Element) -> None:
        """Adds shapes that belong to the world itself, such as a half space."""
        geometries = self._plant.GetCollisionGeometriesForBody(self._plant.world_body())
        if geometries:
            model = ET.SubElement(world, "model", name="ground")
            ET.SubElement(model, "static").text = "true"
            link = ET.SubElement(model, "link", name="ground")
            for geometry in geometries:
                self._add_shape(link, geometry, self._inspector.GetPoseInFrame(geometry))

    def _add_joint(self, model: ET.Element, joint: Joint) -> None:
        parent, child = joint.parent_body(), joint.child_body()
        is_fixed = isinstance(joint, WeldJoint)
        kind = "fixed" if is_fixed else "revolute" if isinstance(joint, RevoluteJoint) else "prismatic"
        element = ET.SubElement(model, "joint", name=f"{_name(child)}__{joint.name()}", type=kind)
        ET.SubElement(element, "parent").text = "world" if parent.index() == 0 else _name(parent)
        ET.SubElement(element, "child").text = _name(child)
        if is_fixed:
            return
        _pose(element, joint.frame_on_child().GetFixedPoseInBodyFrame())
        axis = ET.SubElement(element, "axis")
        ET.SubElement(axis, "xyz").text = text(axis_of(joint))
        low, high = joint.position_lower_limit(), joint.position_upper_limit()
        if np.isfinite([low, high]).all():
            limit = ET.SubElement(axis, "limit")
            ET.SubElement(limit, "lower").text, ET.SubElement(limit, "upper").text = text([low]), text([high])
        stiffness, damping = self._springs.get(joint.index(), (0.0, joint.default_damping()))
        dynamics = ET.SubElement(axis, "dynamics")
        for name, value in (("damping", damping), ("spring_stiffness", stiffness), ("spring_reference", 0.0)):
            ET.SubElement(dynamics, name).text = text([value])

    def _add_inertia(self, link: ET.Element, body: RigidBody) -> None:
        """Adds the inertia; without one, SDFormat would assume 1 kg."""
        mass, element = body.default_mass(), ET.SubElement(link, "inertial")
        values = [_NO_MASS] * 3 + [0.0] * 3
        if mass > 0:
            inertia = inertia_of(body)
            values = [*inertia.get_moments(), *inertia.get_products()]
            _pose(element, RigidTransform(body.default_com()))
        ET.SubElement(element, "mass").text = text([max(mass, _NO_MASS)])
        moments = ET.SubElement(element, "inertia")
        for name, value in zip(_INERTIA, values, strict=True):
            ET.SubElement(moments, name).text = text([value])

    def _add_shape(self, link: ET.Element, geometry: GeometryId, X_BG: RigidTransform) -> None:
        properties = self._inspector.GetProximityProperties(geometry)
        if properties is None:
            return  # nothing can ever touch it
        friction = properties.GetProperty("material", "coulomb_friction").static_friction()
        count = len(link.findall("collision"))
        collision = ET.SubElement(link, "collision", name=f"collision_{count}")
        _pose(collision, X_BG)
        ode = ET.SubElement(ET.SubElement(ET.SubElement(collision, "surface"), "friction"), "ode")
        ET.SubElement(ode, "mu").text = ET.SubElement(ode, "mu2").text = text([friction])
        visual = ET.SubElement(link, "visual", name=f"visual_{count}")
        _pose(visual, X_BG)
        for element in (collision, visual):
            self._describe(ET.SubElement(element, "geometry"), self._inspector.GetShape(geometry))

    def _describe(self, element: ET.Element, shape: Shape) -> None:
        kinds: dict[type[Shape], tuple[str, Any]] = {
            Box: ("box", lambda box: {"size": box.size()}),
            Sphere: ("sphere", lambda ball: {"radius": [ball.radius()]}),
            Cylinder: ("cylinder", lambda rod: {"radius": [rod.radius()], "length": [rod.length()]}),
            Capsule: ("capsule", lambda rod: {"radius": [rod.radius()], "length": [rod.length()]}),
            Ellipsoid: ("ellipsoid", lambda egg: {"radii": [egg.a(), egg.b(), egg.c()]}),
            HalfSpace: ("plane", lambda _: {"normal": [0, 0, 1], "size": [1, 1]}),
            Mesh: ("mesh", lambda mesh: {"scale": mesh.scale3()}),
            Convex: ("mesh", lambda mesh: {"scale": mesh.scale3()}),
        }
        if type(shape) not in kinds:
            raise InputError("export", "shape", type(shape).__name__, "has no counterpart in SDFormat")
        kind, sizes = kinds[type(shape)]
        found = ET.SubElement(element, kind)
        if isinstance(shape, Mesh | Convex):
            source = Path(shape.source().path())
            self._meshes[source.name] = source
            ET.SubElement(found, "uri").text = f"meshes/{source.name}"
        for name, values in sizes(shape).items():
            ET.SubElement(found, name).text = text(values)


def _pose(element: ET.Element, X: RigidTransform) -> None:
    w, x, y, z = X.rotation().ToQuaternion().wxyz()
    ET.SubElement(element, "pose", rotation_format="quat_xyzw").text = text([*X.translation(), x, y, z, w])


def _name(body: RigidBody) -> str:
    return str(body.scoped_name()).replace("::", "__")
