"""A scenario as MJCF: bodies, joints, springs, chambers, contacts and objects of the finalized plant.

All numbers are written in full precision. A chamber is a fixed tendon along the
joints of its finger, weighted by the pressure gain of each, that an actuator with the lag of the supply pulls at. A
branch of creep is an actuator at every joint, whose activation is the internal angle: it follows the angle of the
joint, which is its command.

MuJoCo knows contact at points only, so that a finger has the points under its skin of `contact: points`, of the same
stiffness.
"""

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
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
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import Joint, RevoluteJoint, RigidBody, WeldJoint

from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.drive import chambers_turn
from soft_gripper.errors import InputError
from soft_gripper.extras.export.actuation import (
    ArmActuator,
    CommandSchedule,
    arm_actuators,
    chamber_names,
    make_commands,
)
from soft_gripper.extras.export.mjcf_contact import ShapeSurface, contact_settings
from soft_gripper.extras.export.reach import Ball, ShapeRange, extent, may_touch, reaches
from soft_gripper.extras.export.tree import (
    central_inertia,
    child_joints,
    exports_creep,
    joint_axis,
    missing_properties,
    mobilities,
    neighbors,
    scoped_name,
    springs,
    text,
    tree_depth,
    zero_pose,
)
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.deformables import is_deformable
from soft_gripper.scenario.schema import Scenario

# s, longest step of the integrator implicitfast, for which contacts act by the state at the begin of a step: half of
# the shortest time constant of a contact. The integrator discrete takes longer steps, and damps motion.
MAX_DEPTH = 496  # bodies inside each other that MuJoCo reads
EXPLICIT_STEP = 0.002
_RIGID_STIFFNESS = 1e9  # N/m; a stiffer shape is not a skin
_COUPLING_IMPEDANCE = "0.999 0.9999 0.001"  # solimp of MuJoCo, of the couplings of joints
_MIN_GYRATION = 3e-5  # m, radius of gyration that a body has at least
_MIN_INERTIA = 2e-14  # kg m^2: MuJoCo takes none of 1e-14 or less, which links without a mass have in SDFormat
_PLANE_SIZE = "1 1 0.1"  # m, of a plane as it is drawn; it has no end


class Mjcf(NamedTuple):
    """A scenario as MJCF."""

    text: str
    meshes: Mapping[str, Path]  # files that the text names, by their names in it
    actuators: Sequence[str]  # that are commanded: effective pressures of chambers, Pa; positions of joints of an arm
    commands: CommandSchedule  # of the actuators, over time
    left_out: Sequence[str]  # properties that MuJoCo simulates otherwise, or not at all
    pairs: Sequence["Pair"]


def to_mjcf(scenario: Scenario, time_step: float | None = None) -> Mjcf:
    """A scenario as MJCF.

    Args:
        scenario: to be written.
        time_step: s; None: that of the scenario, or 2 ms if it is continuous.

    Raises:
        InputError: if a part of the scenario cannot be built, is soft, or has a joint or a shape without a counterpart,
            or the time step is not above 0.
    """
    if time_step is not None and not 0 < time_step < np.inf:
        raise InputError("export", "time_step", time_step, "give a number of seconds above 0")
    for model in scenario.models:
        if is_deformable(model.mesh):
            raise InputError("export", "models", model.name, "is soft; rigid objects can be exported")
    models = [replace(model, self_contact=False) for model in scenario.models]
    step = time_step or scenario.plant_config.time_step or EXPLICIT_STEP
    mjcf = station_mjcf(make_station(replace(scenario, models=models, contact="points")), step, step <= EXPLICIT_STEP)
    left_out = [f"{model.name}: self_contact of its fingers" for model in scenario.models if model.self_contact]
    return mjcf._replace(left_out=[*mjcf.left_out, *left_out])


class Pair(NamedTuple):
    """Two shapes of a file with contact settings for this pair."""

    name: str
    models: tuple[str, str]  # to which they belong
    surfaces: tuple[ShapeSurface, ShapeSurface]


def station_mjcf(station: Station, time_step: float, is_explicit: bool, listed: Collection[str] = ()) -> Mjcf:
    """A station of rigid bodies as MJCF; fingers touch other bodies at points, and not themselves; see `to_mjcf`.

    Args:
        station: made with contact at points.
        time_step: s.
        is_explicit: for the integrator implicitfast, whose springs pull as they are at the begin of a step; otherwise
            for discrete, which older versions of MuJoCo and other engines do not have.
        listed: names of models that touch others in pairs only, so that a contact can be changed.

    Raises:
        InputError: if more links hang on each other than MuJoCo reads.
    """
    if (depth := tree_depth(station.plant)) > MAX_DEPTH:
        expected = f"MuJoCo reads at most {MAX_DEPTH} links that hang on each other; give fingers fewer segments"
        raise InputError("scenario", "models", f"{depth} links", expected)
    return _Writer(station, time_step, is_explicit, listed).write()


class _Writer:
    """Writes one station."""

    def __init__(self, station: Station, step: float, is_explicit: bool, listed: Collection[str]):
        self._listed = listed
        self._pairs = list[Pair]()
        self._station, self._scenario, self._plant = station, station.scenario, station.plant
        self._step = step
        self._is_explicit = is_explicit
        self._inspector: SceneGraphInspector = station.parts.scene_graph.model_inspector()
        self._context = self._plant.CreateDefaultContext()
        self._positions = self._plant.GetPositions(self._context)
        self._qpos: list[float] = []  # in the order of the joints in the file
        self._names: list[str] = []  # of the actuators
        self._tips = {finger.links[-1].index(): finger for finger in station.fingers}
        self._root = ET.Element("mujoco", model="scenario")
        self._assets = ET.Element("asset")
        self._meshes: dict[str, Path] = {}
        self._geoms: dict[GeometryId, ET.Element] = {}
        self._children = child_joints(self._plant)
        self._reaches = reaches(self._plant, self._children)
        self._springs = dict(springs(station.fingers))
        self._left_out = [*missing_properties(station), *self._approximations()]
        gains = {actuator.joint.index(): (actuator.stiffness, actuator.damping) for actuator in arm_actuators(station)}
        self._mobilities = mobilities(self._plant, self._springs | gains, 0.0 if self._is_explicit else step)

    def _approximations(self) -> Iterator[str]:
        if not self._is_explicit:
            yield f"how fast objects slip: in steps of {1e3 * self._step:g} ms they slide slowly; see --time-step"
        for finger in self._station.fingers:
            points = self._scenario.contact_points
            model = finger.finger
            yield f"{finger.name}: contact over surfaces; it touches at {points} points on either side of every link"
            if model.creep and not exports_creep(finger):
                yield f"{finger.name}: creep, which its pressure_law multiplies"
            if any(model.laws):
                yield f"{finger.name}: that its pressure_law follows the lag; commands are effective pressures"
            if chambers_turn(finger):
                yield f"{finger.name}: chambers that turn as it twists; their torques are those of the straight finger"

    def write(self) -> Mjcf:
        ET.SubElement(self._root, "compiler", angle="radian", meshdir="meshes", autolimits="true")
        option = {"timestep": repr(self._step), "gravity": text(self._scenario.gravity)}
        option |= {"integrator": "implicitfast" if self._is_explicit else "discrete"}
        option |= {"cone": "elliptic", "impratio": "10", "noslip_iterations": "10"}
        ET.SubElement(self._root, "option", option)
        self._root.append(self._assets)
        world = ET.SubElement(self._root, "worldbody")
        self._add_geoms(world, self._plant.world_body())
        self._add_children(world, self._plant.world_body())
        self._add_contacts(ET.SubElement(self._root, "contact"))
        self._add_couplings(ET.SubElement(self._root, "equality"))
        tendons = ET.SubElement(self._root, "tendon")
        actuators = ET.SubElement(self._root, "actuator")
        for finger in self._station.fingers:
            self._add_chambers(tendons, actuators, finger)
        for actuator in arm_actuators(self._station):
            self._add_position(actuators, actuator)
        for finger in self._station.fingers:
            self._add_creep(actuators, finger)
        commands = make_commands(self._station)
        begin_commands = [*np.zeros(commands.pressures.shape[1]), *commands.arm[0]]
        # The state in which a run begins: empty chambers, and an arm that carries its weight.
        ctrl = [*begin_commands, *np.zeros(len(actuators) - len(begin_commands))]
        keyframe = ET.SubElement(self._root, "keyframe")
        ET.SubElement(keyframe, "key", name="home", qpos=text(self._qpos), ctrl=text(ctrl))
        ET.indent(self._root)
        content = ET.tostring(self._root, encoding="unicode") + "\n"
        return Mjcf(content, self._meshes, self._names, commands, self._left_out, self._pairs)

    def _add_children(self, element: ET.Element, parent: RigidBody) -> None:
        for joint in self._children.get(parent.index(), []):
            child = joint.child_body()
            X_PC = zero_pose(joint)
            body = ET.SubElement(element, "body", {"name": _name(child)} | _pose_attributes(X_PC))
            self._add_joint(body, joint)
            self._add_inertia(body, child)
            self._add_geoms(body, child)
            if child.index() in self._tips:
                finger = self._tips[child.index()]
                X_LT = finger.frames[-1].GetFixedPoseInBodyFrame()
                ET.SubElement(body, "site", {"name": f"{finger.name} tip"} | _pose_attributes(X_LT))
            self._add_children(body, child)

    def _add_joint(self, body: ET.Element, joint: Joint) -> None:
        if isinstance(joint, WeldJoint):
            return
        if joint.child_body().is_floating_base_body():
            ET.SubElement(body, "freejoint", name=scoped_name(joint))
            X_WB = self._plant.GetDefaultFloatingBaseBodyPose(joint.child_body())
            self._qpos += [*X_WB.translation(), *X_WB.rotation().ToQuaternion().wxyz()]
            return
        axis = joint_axis(joint)
        kind = "hinge" if isinstance(joint, RevoluteJoint) else "slide"
        X_CM = joint.frame_on_child().GetFixedPoseInBodyFrame()
        stiffness, damping = self._springs.get(joint.index(), (0.0, joint.default_damping()))
        settings = {"name": scoped_name(joint), "type": kind}
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
        inertia = central_inertia(body)
        # MuJoCo takes no inertia of zero, which point masses have, and rods about their axes.
        shortfall = max(_MIN_GYRATION**2 * mass, _MIN_INERTIA) - np.linalg.eigvalsh(inertia.CopyToFullMatrix3()).min()
        tensor = text([*(inertia.get_moments() + max(shortfall, 0.0)), *inertia.get_products()])
        ET.SubElement(element, "inertial", pos=text(body.default_com()), mass=repr(float(mass)), fullinertia=tensor)

    def _add_geoms(self, element: ET.Element, body: RigidBody) -> None:
        for geometry in self._plant.GetCollisionGeometriesForBody(body):
            if self._inspector.GetProximityProperties(geometry) is None:
                continue  # nothing can ever touch it
            name = f"{_name(body)} {len(self._geoms)}"
            settings = {"name": name, "group": "3"} | self._shape(self._inspector.GetShape(geometry), name)
            settings |= _pose_attributes(self._inspector.GetPoseInFrame(geometry))
            self._geoms[geometry] = ET.SubElement(element, "geom", settings)

    def _shape(self, shape: Shape, name: str) -> dict[str, str]:
        if isinstance(shape, Mesh | Convex):
            self._add_mesh(shape, name)
            return {"type": "mesh", "mesh": name}
        kinds: dict[type[Shape], tuple[str, Any]] = {
            Box: ("box", lambda box: box.size() / 2),
            Sphere: ("sphere", lambda ball: [ball.radius()]),
            Cylinder: ("cylinder", lambda rod: [rod.radius(), rod.length() / 2]),
            Capsule: ("capsule", lambda rod: [rod.radius(), rod.length() / 2]),
            Ellipsoid: ("ellipsoid", lambda egg: [egg.a(), egg.b(), egg.c()]),
        }
        if isinstance(shape, HalfSpace):
            return {"type": "plane", "size": _PLANE_SIZE}
        if type(shape) not in kinds:
            raise InputError("export", "shape", type(shape).__name__, "has no counterpart in MJCF")
        kind, size = kinds[type(shape)]
        return {"type": kind, "size": text(size(shape))}

    def _add_mesh(self, shape: Mesh | Convex, name: str) -> None:
        """Adds a mesh by its file, or a convex part of one by its corners."""
        if isinstance(shape, Convex):
            hull = shape.GetConvexHull()
            corners = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
            ET.SubElement(self._assets, "mesh", name=name, vertex=text(corners.ravel()))
            return
        source = Path(shape.source().path())
        file = f"mesh_{len(self._meshes)}{source.suffix}"
        self._meshes[file] = source
        ET.SubElement(self._assets, "mesh", name=name, file=file, scale=text(shape.scale3()))

    def _add_contacts(self, contact: ET.Element) -> None:
        """Adds contact attributes to every shape, and pairs whose contacts differ from these attributes."""
        elements = list(self._geoms.values())
        bodies = [self._geometry_body(geometry) for geometry in self._geoms]
        ranges = [self._shape_range(*shape) for shape in zip(self._geoms, bodies, strict=True)]
        fixed_indices = {i for i, shape_range in enumerate(ranges) if shape_range.X_WG is not None}
        is_filtered = self._inspector.CollisionFiltered
        geometries = list(self._geoms)
        order = sorted(range(len(geometries)), key=lambda i: geometries[i].get_value())  # as in Drake
        candidates = sorted(
            (k, j)
            for k, j in combinations(order, 2)
            if not is_filtered(geometries[k], geometries[j])
            and (fixed_indices.isdisjoint((k, j)) or may_touch(ranges[k], ranges[j]))
        )
        indices = [int(body.index()) for body in bodies]
        close = {int(body): {int(j) for j in neighbours} for body, neighbours in neighbors(self._plant).items()}
        filtered = {(k, j) for k, j in candidates if indices[j] in close[indices[k]]}
        surfaces = self._surfaces()
        models = [self._plant.GetModelInstanceName(body.model_instance()) for body in bodies]
        listed = {number for number, model in enumerate(models) if model in self._listed}
        contacts = contact_settings(surfaces, candidates, filtered, self._scenario.contact_points, self._step, listed)
        for element, settings in zip(elements, contacts.geoms, strict=True):
            element.attrib.update(settings)
        for (k, j), settings in contacts.pairs.items():
            name = f"pair {len(self._pairs)}"
            names = {"name": name, "geom1": elements[k].attrib["name"], "geom2": elements[j].attrib["name"]}
            ET.SubElement(contact, "pair", names | settings)
            self._pairs.append(Pair(name, (models[k], models[j]), (surfaces[k], surfaces[j])))

    def _shape_range(self, geometry: GeometryId, body: RigidBody) -> ShapeRange:
        """The range of places of a shape of a body."""
        shape = self._inspector.GetShape(geometry)
        X_BG = self._inspector.GetPoseInFrame(geometry)
        ball = self._reaches[body.index()]
        X_WG = body.EvalPoseInWorld(self._context) @ X_BG
        return ShapeRange(
            Ball(ball.center, ball.radius + extent(shape, X_BG)), shape, X_WG if ball.radius == 0 else None
        )

    def _surfaces(self) -> list[ShapeSurface]:
        """The surfaces of all shapes."""
        frictions = [
            self._contact_property(geometry, "coulomb_friction", CoulombFriction()).static_friction()
            for geometry in self._geoms
        ]
        stiffnesses = [self._contact_property(geometry, "point_contact_stiffness", np.inf) for geometry in self._geoms]
        compliances = [1 / stiffness if stiffness < _RIGID_STIFFNESS else 0.0 for stiffness in stiffnesses]
        mobilities = [self._mobilities[self._geometry_body(geometry).index()] for geometry in self._geoms]
        return list(map(ShapeSurface, frictions, compliances, mobilities))

    def _contact_property(self, geometry: GeometryId, name: str, default: Any) -> Any:
        return self._inspector.GetProximityProperties(geometry).GetPropertyOrDefault("material", name, default)

    def _geometry_body(self, geometry: GeometryId) -> RigidBody:
        return self._plant.GetBodyFromFrameId(self._inspector.GetFrameId(geometry))

    def _add_couplings(self, equality: ET.Element) -> None:
        """Couples joints to those they follow, as stiffly as the time step permits."""
        for model, mimics in self._station.parts.mimics.items():
            for mimic in mimics:
                settings = {"joint1": f"{model}::{mimic.joint}", "joint2": f"{model}::{mimic.leader}"}
                settings |= {"polycoef": text([mimic.offset, mimic.multiplier, 0, 0, 0])}
                ET.SubElement(equality, "joint", settings, solref=text([2 * self._step, 1]), solimp=_COUPLING_IMPEDANCE)

    def _add_chambers(self, tendons: ET.Element, actuators: ET.Element, finger: PlantFinger) -> None:
        """Adds the chambers of a finger, and their actuators."""
        gains = finger.finger.pressure_gains
        supply = self._scenario.pressure
        limits = np.outer([supply.minimum, supply.maximum], np.ones(finger.finger.pressures))
        ranges = finger.finger.effective_pressure(limits).T
        for chamber, (name, limit) in enumerate(zip(chamber_names(finger), ranges, strict=True)):
            tendon = ET.SubElement(tendons, "fixed", name=f"{name} chamber")
            for deformation in finger.finger.driven_deformations:
                for joint, gain in zip(finger.joints_of(deformation), gains[deformation][chamber], strict=True):
                    ET.SubElement(tendon, "joint", joint=scoped_name(joint), coef=repr(float(gain)))
            settings = {"name": name, "tendon": f"{name} chamber", "gainprm": "1", "biastype": "none"}
            settings["ctrlrange"] = text(limit)
            if supply.time_constant > 0:
                settings |= {"dyntype": "filterexact", "dynprm": repr(supply.time_constant)}
            ET.SubElement(actuators, "general", settings)
            self._names.append(name)

    def _add_creep(self, actuators: ET.Element, finger: PlantFinger) -> None:
        """Adds the branches of creep: each follows the angle of its joint, its command."""
        for number, branch in enumerate(finger.finger.creep if exports_creep(finger) else ()):
            for joint, k in zip(finger.joints, finger.finger.stiffness, strict=True):
                name = scoped_name(joint)
                settings = {"name": f"{name} creep {number}", "joint": name, "biastype": "none"}
                settings |= {"gainprm": repr(float(branch.share * k)), "dyntype": "filterexact"}
                ET.SubElement(actuators, "general", settings, dynprm=repr(branch.time))

    def _add_position(self, actuators: ET.Element, actuator: ArmActuator) -> None:
        """Adds the PD controller of a joint of an arm."""
        name = scoped_name(actuator.joint)
        settings = {"name": name, "joint": name, "kp": repr(actuator.stiffness), "kv": repr(actuator.damping)}
        if np.isfinite(actuator.effort):
            settings["forcerange"] = text([-actuator.effort, actuator.effort])
        ET.SubElement(actuators, "position", settings)
        self._names.append(name)


def _name(body: RigidBody) -> str:
    return str(body.scoped_name())


def _pose_attributes(X: RigidTransform) -> dict[str, str]:
    return {"pos": text(X.translation()), "quat": text(X.rotation().ToQuaternion().wxyz())}
