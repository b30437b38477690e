"""A scenario as MJCF: bodies, joints, springs, chambers, contacts and objects as they stand in the finalized plant.

All numbers are written in full precision. Every pair of shapes that may touch is listed, with the friction of the pair
as Drake combines it: MuJoCo by itself would take the larger of two coefficients. A chamber is a fixed tendon along the
joints of its finger, weighted by the pressure gain of each, that an actuator with the lag of the supply pulls at.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    HalfSpace,
    Mesh,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.tree import Joint, JointActuator, RevoluteJoint, RigidBody, WeldJoint

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.export.tree import axis_of, inertia_of, joints_below, left_out, pose_at_zero, springs, text
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import Scenario
from soft_gripper.truth.contact import combined_friction

LONGEST_STEP = 0.002  # s
# Time constant, s, and damping ratio of contacts. With MuJoCo's 0.02 s light links sink in; see docs/export.md.
_SOLREF = "0.004 1"
_HALF_SPACE = "1 1 0.1"  # m, of a plane as it is drawn; it has no end


class Mjcf(NamedTuple):
    """A scenario as MJCF."""

    text: str
    meshes: Mapping[str, Path]  # files that the text names, by their names in it
    actuators: Sequence[str]  # pressures of chambers, Pa, and then positions of joints of an arm
    arm: Sequence[float]  # commands that hold the arm where a run begins, of the last actuators
    left_out: Sequence[str]  # what MuJoCo simulates otherwise, or not at all


def to_mjcf(scenario: Scenario) -> Mjcf:
    """A scenario as MJCF.

    Raises:
        InputError: if a part of the scenario cannot be built, or has a joint or a shape without a counterpart.
    """
    return _Writer(make_station(scenario)).write()


class _Writer:
    """Writes one station."""

    def __init__(self, station: Station):
        self._station, self._scenario, self._plant = station, station.scenario, station.plant
        self._inspector: SceneGraphInspector = station.parts.scene_graph.model_inspector()
        self._context = self._plant.CreateDefaultContext()
        self._positions = self._plant.GetPositions(self._context)
        self._qpos: list[float] = []  # in the order of the joints in the file
        self._names: list[str] = []  # of the actuators
        self._arm_joints: list[tuple[Joint, float]] = []  # and the stiffnesses of their controllers
        self._tips = {finger.links[-1].index(): finger for finger in station.fingers}
        self._root = ET.Element("mujoco", model="scenario")
        self._assets = ET.Element("asset")
        self._meshes: dict[str, Path] = {}
        self._geoms: dict[GeometryId, str] = {}
        self._children = joints_below(self._plant)
        self._springs = dict(springs(station.fingers))
        self._left_out = list(left_out(station))

    def write(self) -> Mjcf:
        step = min(self._scenario.plant_config.time_step or LONGEST_STEP, LONGEST_STEP)
        ET.SubElement(self._root, "compiler", angle="radian", meshdir="meshes", autolimits="true")
        option = {"timestep": repr(step), "gravity": text(self._scenario.gravity), "integrator": "implicitfast"}
        option |= {"cone": "elliptic", "impratio": "10", "noslip_iterations": "10"}
        ET.SubElement(self._root, "option", option)
        self._root.append(self._assets)
        world = ET.SubElement(self._root, "worldbody")
        self._add_geoms(world, self._plant.world_body())
        self._add_children(world, self._plant.world_body())
        self._add_pairs(ET.SubElement(self._root, "contact"))
        tendons, actuators = ET.SubElement(self._root, "tendon"), ET.SubElement(self._root, "actuator")
        for finger in self._station.fingers:
            self._add_chambers(tendons, actuators, finger)
        self._add_positions(actuators)
        arm = [self._held_at(*each) for each in self._arm_joints]
        self._add_home(arm)
        ET.indent(self._root)
        return Mjcf(ET.tostring(self._root, encoding="unicode") + "\n", self._meshes, self._names, arm, self._left_out)

    def _add_children(self, element: ET.Element, parent: RigidBody) -> None:
        for joint in self._children.get(parent.index(), []):
            child = joint.child_body()
            X_PC = pose_at_zero(joint)
            body = ET.SubElement(element, "body", {"name": _name(child)} | _placed(X_PC))
            self._add_joint(body, joint)
            self._add_inertia(body, child)
            self._add_geoms(body, child)
            if child.index() in self._tips:
                finger = self._tips[child.index()]
                X_LT = finger.frames[-1].GetFixedPoseInBodyFrame()
                ET.SubElement(body, "site", {"name": f"{finger.name} tip"} | _placed(X_LT))
            self._add_children(body, child)

    def _add_joint(self, body: ET.Element, joint: Joint) -> None:
        if isinstance(joint, WeldJoint):
            return
        if joint.child_body().is_floating_base_body():
            ET.SubElement(body, "freejoint", name=_joint_name(joint))
            X_WB = self._plant.GetDefaultFloatingBaseBodyPose(joint.child_body())
            self._qpos += [*X_WB.translation(), *X_WB.rotation().ToQuaternion().wxyz()]
            return
        axis, kind = axis_of(joint), "hinge" if isinstance(joint, RevoluteJoint) else "slide"
        X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame()
        stiffness, damping = self._springs.get(joint.index(), (0.0, joint.default_damping()))
        settings = {"name": _joint_name(joint), "type": kind}
        settings |= {"pos": text(X_CM.translation()), "axis": text(X_CM.rotation() @ axis)}
        settings |= {"stiffness": repr(float(stiffness)), "damping": repr(float(damping))}
        low, high = joint.position_lower_limit(), joint.position_upper_limit()
        if np.isfinite([low, high]).all():
            settings["range"] = text([low, high])
        ET.SubElement(body, "joint", settings)
        self._qpos.append(float(self._positions[joint.position_start()]))

    def _add_inertia(self, element: ET.Element, body: RigidBody) -> None:
        mass = body.default_mass()
        if not mass > 0:
            return
        inertia = inertia_of(body)
        full = text([*inertia.get_moments(), *inertia.get_products()])
        ET.SubElement(element, "inertial", pos=text(body.default_com()), mass=repr(float(mass)), fullinertia=full)

    def _add_geoms(self, element: ET.Element, body: RigidBody) -> None:
        for geometry in self._plant.GetCollisionGeometriesForBody(body):
            if self._inspector.GetProximityProperties(geometry) is None:
                continue  # nothing can ever touch it
            name = f"{_name(body)} {len(self._geoms)}"
            self._geoms[geometry] = name
            settings = {"name": name, "contype": "0", "conaffinity": "0", "group": "3"}
            settings |= self._shape(self._inspector.GetShape(geometry), name)
            ET.SubElement(element, "geom", settings | _placed(self._inspector.GetPoseInFrame(geometry)))

    def _shape(self, shape: Shape, name: str) -> dict[str, str]:
        if isinstance(shape, Mesh | Convex):
            return {"type": "mesh", "mesh": self._add_mesh(shape, name)}
        kinds: dict[type[Shape], tuple[str, Any]] = {
            Box: ("box", lambda box: box.size() / 2),
            Sphere: ("sphere", lambda ball: [ball.radius()]),
            Cylinder: ("cylinder", lambda rod: [rod.radius(), rod.length() / 2]),
            Capsule: ("capsule", lambda rod: [rod.radius(), rod.length() / 2]),
            Ellipsoid: ("ellipsoid", lambda egg: [egg.a(), egg.b(), egg.c()]),
        }
        if isinstance(shape, HalfSpace):
            return {"type": "plane", "size": _HALF_SPACE}
        if type(shape) not in kinds:
            raise InputError("export", "shape", type(shape).__name__, "has no counterpart in MJCF")
        kind, size = kinds[type(shape)]
        return {"type": kind, "size": text(size(shape))}

    def _add_mesh(self, shape: Mesh | Convex, name: str) -> str:
        source = Path(shape.source().path())
        file = f"mesh_{len(self._meshes)}{source.suffix}"
        self._meshes[file] = source
        if isinstance(shape, Mesh):
            self._left_out.append(f"{name}: MuJoCo lets others touch the convex hull of a mesh, not its surface")
        ET.SubElement(self._assets, "mesh", name=name, file=file, scale=text(shape.scale3()))
        return name

    def _add_pairs(self, contact: ET.Element) -> None:
        for one, other in sorted(self._inspector.GetCollisionCandidates(), key=_values):
            if one in self._geoms and other in self._geoms:
                friction = combined_friction(self._friction(one), self._friction(other))
                settings = {"geom1": self._geoms[one], "geom2": self._geoms[other], "condim": "3", "solref": _SOLREF}
                ET.SubElement(contact, "pair", settings, friction=text([friction, friction, 0.005, 1e-4, 1e-4]))

    def _friction(self, geometry: GeometryId) -> float:
        properties = self._inspector.GetProximityProperties(geometry)
        return float(properties.GetProperty("material", "coulomb_friction").static_friction())

    def _add_chambers(self, tendons: ET.Element, actuators: ET.Element, finger: PlantFinger) -> None:
        """Adds the chambers of a finger, and their actuators."""
        gains, supply = finger.finger.pressure_gains, self._scenario.pressure
        labels = [label for labels in finger.finger.chamber_axis.values() for label in labels]
        for chamber in range(finger.finger.pressures):
            name = f"{finger.name}::{labels[chamber]}" if labels else finger.name
            tendon = ET.SubElement(tendons, "fixed", name=f"{name} chamber")
            for way in finger.finger.driven_ways:
                for joint, gain in zip(finger.joints_of(way), gains[way][chamber], strict=True):
                    ET.SubElement(tendon, "joint", joint=_joint_name(joint), coef=repr(float(gain)))
            settings = {"name": name, "tendon": f"{name} chamber", "gainprm": "1", "biastype": "none"}
            settings["ctrlrange"] = text([supply.minimum, supply.maximum])
            if supply.time_constant > 0:
                settings |= {"dyntype": "filterexact", "dynprm": repr(supply.time_constant)}
            ET.SubElement(actuators, "general", settings)
            self._names.append(name)

    def _add_positions(self, actuators: ET.Element) -> None:
        """Adds the PD controllers of an arm's joints."""
        for index in self._plant.GetJointActuatorIndices():
            actuator: JointActuator = self._plant.get_joint_actuator(index)
            joint = actuator.joint()
            if joint.index() in self._springs or not actuator.has_controller():
                continue
            gains = actuator.get_controller_gains()
            settings = {"name": _joint_name(joint), "joint": _joint_name(joint), "kp": repr(gains.p)}
            ET.SubElement(actuators, "position", settings, kv=repr(gains.d))
            self._names.append(_joint_name(joint))
            self._arm_joints.append((joint, gains.p))

    def _add_home(self, arm: list[float]) -> None:
        """Adds the state in which a run begins; commands to an arm also carry its weight there."""
        ctrl = [0.0] * (len(self._names) - len(arm)) + arm
        keyframe = ET.SubElement(self._root, "keyframe")
        ET.SubElement(keyframe, "key", name="home", qpos=text(self._qpos), ctrl=text(ctrl))

    def _held_at(self, joint: Joint, stiffness: float) -> float:
        """The command at which a PD controller with that stiffness holds a joint of the arm where a run begins."""
        weight = self._plant.CalcGravityGeneralizedForces(self._context)[joint.velocity_start()]
        return float(self._positions[joint.position_start()] - weight / stiffness)


def _name(body: RigidBody) -> str:
    return str(body.scoped_name())


def _joint_name(joint: Joint) -> str:
    return f"{joint.GetParentPlant().GetModelInstanceName(joint.model_instance())}::{joint.name()}"


def _placed(X: RigidTransform) -> dict[str, str]:
    return {"pos": text(X.translation()), "quat": text(X.rotation().ToQuaternion().wxyz())}


def _values(pair: tuple[GeometryId, GeometryId]) -> tuple[int, int]:
    return pair[0].get_value(), pair[1].get_value()
