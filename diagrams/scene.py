"""The plant: models added at their poses, and the fingers found in them."""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import dist
from typing import NamedTuple

import numpy as np
from pydrake.geometry import (
    Box,
    ContactSurface,
    GeometryId,
    HalfSpace,
    HydroelasticContactRepresentation,
    ProximityProperties,
    Role,
    SceneGraph,
    SceneGraphInspector,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, ModelInstanceIndex, RigidBody, world_model_instance
from pydrake.systems.framework import Context, Diagram, DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.control.couplings import Couplings, couplings
from soft_gripper.diagrams.loaded_model import LoadedModel, load_model
from soft_gripper.diagrams.point_contact import prepare_point_contact
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.library_messages import drop_messages
from soft_gripper.model_import.drake_parsing import drake_reads
from soft_gripper.model_import.imported_model import Mimic
from soft_gripper.scenario.deformables import Deformable, deformable_body, deformable_kind
from soft_gripper.scenario.directives import add_directives
from soft_gripper.scenario.model_files import is_mjcf, model_path
from soft_gripper.scenario.schema import ArmConfig, ModelConfig, Scenario

_LOGGER = logging.getLogger(__name__)


def set_home_posture(plant: MultibodyPlant, arm: ArmConfig, mimics: Sequence[Mimic] = ()) -> Couplings:
    """Sets the default positions of the arm to its home posture; returns how its joints depend on each other.

    Raises:
        InputError: if there is no such model, or the posture does not fit its joints.
    """
    if not plant.HasModelInstanceNamed(arm.model):
        raise InputError("arm", "model", arm.model, "no such model")
    joints = arm_joints(plant, plant.GetModelInstanceByName(arm.model))
    if not joints:
        raise InputError("arm", "model", arm.model, "has no joint that moves")
    coupled = couplings([joint.name() for joint in joints], mimics)
    leader_names = [joints[i].name() for i in coupled.leads]
    if len(arm.home) != len(leader_names):
        follow = f"; {', '.join(mimic.joint for mimic in mimics)} follow" if mimics else ""
        raise InputError("arm", "home", arm.home, f"give a position for each of: {', '.join(leader_names)}{follow}")
    leaders = {mimic.joint: mimic.leader for mimic in mimics}
    for joint, position in zip(joints, coupled.full(np.array(arm.home)), strict=True):
        (low,), (high,) = joint.position_lower_limits(), joint.position_upper_limits()
        if not low <= position <= high:
            follows = f"; it follows '{leaders[joint.name()]}'" if joint.name() in leaders else ""
            expected = f"give a position within its limits, {low:g} to {high:g}{follows}"
            raise InputError("arm.home", joint.name(), float(position), expected)
        joint.set_default_positions([position])
    return coupled


def arm_joints(plant: MultibodyPlant, model: ModelInstanceIndex) -> list[Joint]:
    """The movable joints of a model, each with one degree of freedom, in the order of its positions.

    Raises:
        InputError: if a joint has more than one degree of freedom.
    """
    joints = [plant.get_joint(index) for index in plant.GetJointIndices(model)]
    for joint in joints:
        if joint.num_positions() > 1:
            raise InputError("arm", "joint", joint.name(), "has several degrees of freedom; an arm's joints have one")
    return sorted((j for j in joints if j.num_positions()), key=lambda joint: joint.position_start())


def add_model(
    plant: MultibodyPlant,
    config: ModelConfig,
    where: str,
    arm: ArmConfig | None,
    visuals: bool = True,
    points: int | None = None,
) -> LoadedModel:
    """Loads a model and places it.

    Raises:
        InputError: if its file or a frame that it names is invalid.
    """
    loaded_model = load_model(plant, config, where, arm, visuals, points)
    if arm is not None and config.initial_position:
        raise InputError(where, "initial_position", config.initial_position, "leave it out: an arm has arm.home")
    set_initial_position(plant, loaded_model.model, config.initial_position, loaded_model.mimics, where)
    X_PC = config.X_PC.GetDeterministicValue()
    joints = (plant.get_joint(index) for index in plant.GetJointIndices(loaded_model.model))
    is_joined = any(joint.parent_body().index() == plant.world_body().index() for joint in joints)
    deformable = deformable_body(plant, loaded_model.model)
    if deformable is not None:
        deformable.set_default_pose(X_PC)
    elif is_mjcf(model_path(config.file)) and is_joined:
        _check_stays(config, where)
    elif stays_in_place(config):
        raise InputError(where, "free", False, f"must be true: no joint of {config.file} holds the model")
    elif config.free:
        plant.SetDefaultFloatingBaseBodyPose(first_body(plant, config.name), X_PC)
    else:
        plant.WeldFrames(find_frame(plant, config.parent, where, "parent"), own_frame(plant, config, where), X_PC)
    return loaded_model


def set_initial_position(
    plant: MultibodyPlant,
    model: ModelInstanceIndex,
    positions: Mapping[str, Sequence[float]],
    mimics: Sequence[Mimic],
    where: str,
) -> None:
    """Sets default positions of joints of a model, rad or m by their names; joints that follow others go along.

    Raises:
        InputError: for a joint that is unknown, does not move or follows another, or a position beyond its limits.
    """
    joints = {joint.name(): joint for joint in map(plant.get_joint, plant.GetJointIndices(model))}
    following = {mimic.joint: mimic.leader for mimic in mimics}
    joint_positions = {name: np.array(position) for name, position in positions.items()}
    for name, position in joint_positions.items():
        if name in following:
            raise InputError(where, f"initial_position.{name}", [*position], f"leave it out: follows {following[name]}")
    for mimic in mimics:
        if mimic.leader in joint_positions:
            joint_positions[mimic.joint] = mimic.multiplier * joint_positions[mimic.leader] + mimic.offset
    for name, position in joint_positions.items():
        joint = joints.get(name)
        if joint is None or joint.num_positions() == 0:
            movable_names = (name for name, joint in joints.items() if joint.num_positions() and name not in following)
            expected = f"no joint that moves has this name; known: {', '.join(movable_names) or 'none'}"
            raise InputError(where, f"initial_position.{name}", [*position], expected)
        low, high = joint.position_lower_limits(), joint.position_upper_limits()
        if len(position) != len(low):
            raise InputError(where, f"initial_position.{name}", [*position], f"give {len(low)} numbers, in a list")
        if not np.all((low <= position) & (position <= high)):
            limits = " and ".join(f"{minimum:g} to {maximum:g}" for minimum, maximum in zip(low, high, strict=True))
            follows = f"; it follows '{following[name]}'" if name in following else ""
            expected = f"must be within the limits of the joint, {limits}{follows}"
            raise InputError(where, f"initial_position.{name}", [*position], expected)
        joint.set_default_positions(position)


def stays_in_place(config: ModelConfig) -> bool:
    """Whether a model stays where its file puts it, in the world: so does all that is not free in MJCF."""
    return not config.free and is_mjcf(model_path(config.file))


def _check_stays(config: ModelConfig, where: str) -> None:
    """Raises an InputError if a scenario places a model that stays where its file puts it."""
    is_moved = not config.X_PC.GetDeterministicValue().IsExactlyIdentity()
    has_parent, has_child = config.parent != "world", config.child is not None
    given = {"free": config.free, "parent": has_parent, "child": has_child, "X_PC": is_moved}
    for field in [field for field, is_given in given.items() if is_given]:
        expected = f"leave it out: {config.file} is MJCF, which joins the model to the world and says where it stands"
        raise InputError(where, field, getattr(config, field), expected)


def own_frame(plant: MultibodyPlant, config: ModelConfig, where: str) -> Frame:
    """The frame of a model at which it is welded to its parent."""
    if stays_in_place(config):
        return plant.world_frame()
    if config.child is not None:
        return find_frame(plant, f"{config.name}::{config.child}", where, "child")
    return first_body(plant, config.name).body_frame()


def first_body(plant: MultibodyPlant, model: str) -> RigidBody:
    """The first link of a model."""
    return plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(model))[0])


def find_frame(plant: MultibodyPlant, name: str, where: str, field: str) -> Frame:
    """The frame named "world", "model::frame", or as it was added to the world by directives.

    Raises:
        InputError: if there is none; lists the frames of the model.
    """
    if name == "world":
        return plant.world_frame()
    prefix, _, own_name = name.rpartition("::")
    if prefix and plant.HasModelInstanceNamed(prefix):  # whose name may have "::" in it
        model, is_scoped, frame = prefix, "::", own_name
    else:
        model, is_scoped, frame = name.partition("::")
        frame = frame.replace("::", "_")  # of a model in the model, see nested_models.py
    if not is_scoped and plant.HasFrameNamed(name, world_model_instance()):
        return plant.GetFrameByName(name, world_model_instance())
    if not is_scoped:
        raise InputError(where, field, name, 'write "model::frame", or "world"')
    if not plant.HasModelInstanceNamed(model):
        raise InputError(where, field, name, f"no such frame: no model '{model}' precedes this one")
    instance = plant.GetModelInstanceByName(model)
    if not plant.HasFrameNamed(frame, instance):
        frames = (plant.get_frame(index).name() for index in plant.GetFrameIndices(instance))
        joint_suffixes = ("_parent", "_child")  # of Drake's frames
        frame_names = ", ".join(name for name in frames if not name.endswith(joint_suffixes))
        raise InputError(where, field, name, f"no such frame; known: {frame_names}")
    return plant.GetFrameByName(frame, instance)


class Scene(NamedTuple):
    """The plant, the SceneGraph, and the fingers and bodies in them."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    fingers: list[PlantFinger]
    deformables: Mapping[str, Deformable]  # objects of finite elements, by the names of their models
    couplings: Couplings | None  # of the joints of the arm, if there is one
    mimics: Mapping[str, Sequence[Mimic]]  # joints that follow others, by the names of their models


@collect_notes()  # so that the notes on all its models are few
def add_plant(builder: DiagramBuilder, scenario: Scenario, visuals: bool = True) -> Scene:
    """Adds a finalized plant named "plant" and its SceneGraph, with all models of a scenario placed.

    `visuals`: whether Meshcat or a camera is to see the fingers; where nothing looks, their shapes only cost time.

    Raises:
        InputError: if a directive, a model or a finger in it is invalid.
    """
    models, arm, points = scenario.models, scenario.arm, scenario.points
    plant, scene_graph = AddMultibodyPlant(scenario.plant_config, builder)
    plant.mutable_gravity_field().set_gravity_vector(scenario.gravity)
    add_directives(plant, scenario.directives)
    fingers: list[PlantFinger] = []
    mimics: dict[str, Sequence[Mimic]] = {}
    kind = deformable_kind()
    if kind is not None:
        kind.check_models(scenario)
    for i, model in enumerate(models):
        where = f"models[{i}]"
        arm_config = arm if arm is not None and model.name == arm.model else None
        _, model_fingers, mimics[model.name] = add_model(plant, model, where, arm_config, visuals, points)
        if model.half_space:
            make_half_space(plant, scene_graph, model, where)
        if model.free and model_fingers:
            raise InputError(where, "free", True, "fingers need a welded base")
        fingers += model_fingers
    if kind is not None and plant.deformable_model().num_bodies():
        kind.check_scene(scenario)
    with drake_reads("models", "file", [model.file for model in models]):
        if points is not None:
            skins = (plant.GetCollisionGeometriesForBody(link) for finger in fingers for link in finger.links)
            prepare_point_contact(plant, scene_graph, {geometry for link_skins in skins for geometry in link_skins})
        plant.Finalize()
    coupled = None if arm is None else set_home_posture(plant, arm, mimics.get(arm.model, ()))
    names = [model.name for model in models]
    objects = {} if kind is None else kind.objects(plant, scene_graph.model_inspector(), names)
    scene = Scene(plant, scene_graph, fingers, objects, coupled, mimics)
    remove_idle_skins(scene)
    return scene


def add_copy(builder: DiagramBuilder, scene: Scene, models: Sequence[ModelConfig]) -> Scene:
    """Adds a copy of a scene of rigid bodies, in a twentieth of the time that its files take to read.

    Its free `models` may have other poses than in `scene`.
    """
    plant = builder.AddNamedSystem("plant", scene.plant.Clone())
    scene_graph = builder.AddNamedSystem("scene_graph", scene.scene_graph.Clone())
    builder.Connect(scene_graph.get_query_output_port(), plant.get_geometry_query_input_port())
    source = plant.get_source_id()
    builder.Connect(plant.get_geometry_pose_output_port(), scene_graph.get_source_pose_port(source))
    configuration = plant.get_deformable_body_configuration_output_port()
    builder.Connect(configuration, scene_graph.get_source_configuration_port(source))
    plant.SetDefaultPositions(scene.plant.GetDefaultPositions())  # which are not copied
    for model in (candidate for candidate in models if candidate.free):
        plant.SetDefaultFloatingBaseBodyPose(first_body(plant, model.name), model.X_PC.GetDeterministicValue())
    fingers = []
    for finger in scene.fingers:
        springs = (plant.get_force_element(spring.index()) for spring in finger.torsion_springs)
        fingers.append(replace(finger, plant=plant, torsion_springs=tuple(springs)))
    return scene._replace(plant=plant, scene_graph=scene_graph, fingers=fingers)


def make_half_space(plant: MultibodyPlant, scene_graph: SceneGraph, config: ModelConfig, where: str) -> None:
    """Replaces the collision geometry of a welded box, such as a table, by all that lies below its upper face.

    The pressure in a compliant box grows with the depth up to half its thickness; that of the half space grows as fast.
    It belongs to the world: Drake does not survive an infinite geometry in its tree of those that can move.

    Raises:
        InputError: if the model has any other collision geometry, or is not welded to the world.
    """
    inspector = scene_graph.model_inspector()
    source = plant.get_source_id()
    bodies = [plant.get_body(i) for i in plant.GetBodyIndices(plant.GetModelInstanceByName(config.name))]
    geometries = [geometry for body in bodies for geometry in plant.GetCollisionGeometriesForBody(body)]
    shapes = [inspector.GetShape(geometry) for geometry in geometries]
    frame = own_frame(plant, config, where)
    if config.parent != "world" or len(bodies) != 1 or len(shapes) != 1 or not isinstance(shapes[0], Box):
        shape_names = ", ".join(type(shape).__name__ for shape in shapes) or "none"
        expected = f"is for a single link, welded to the world, with one box; its collision geometry: {shape_names}"
        raise InputError(where, "half_space", True, expected)
    (geometry,), (box,) = geometries, shapes
    properties = ProximityProperties(inspector.GetProximityProperties(geometry))
    properties.AddProperty("hydroelastic", "slab_thickness", float(np.min(box.size())) / 2)
    X_BodyTop = inspector.GetPoseInFrame(geometry) @ RigidTransform([0.0, 0.0, box.height() / 2])
    X_WBody = config.X_PC.GetDeterministicValue() @ frame.GetFixedPoseInBodyFrame().inverse()
    name = f"{config.name} half space"
    scene_graph.RemoveRole(source, geometry, Role.kProximity)
    with drop_messages(lambda message: "deformable contact" in message):  # there is none here
        plant.RegisterCollisionGeometry(plant.world_body(), X_WBody @ X_BodyTop, HalfSpace(), name, properties)


class _ReachBall(NamedTuple):
    """A ball that a geometry never leaves."""

    center: Array  # (3,) m in the world
    radius: float  # m

    def meets(self, other: "_ReachBall") -> bool:
        """Whether two geometries may ever touch."""
        return dist(self.center, other.center) <= self.radius + other.radius


def remove_idle_skins(scene: Scene) -> None:
    """Removes the collision geometry of those links of fingers that nothing can ever touch; it would only cost time.

    That is known only where nothing moves but the joints of fingers, and these only turn: then a link cannot leave a
    ball about the base of its finger, whose radius is the length of the finger up to the end of the link.
    """
    plant, scene_graph, fingers, deformables, *_ = scene
    turns = (finger.joints_of(name) for finger in fingers for name in finger.finger.yields if name not in SLIDES)
    other_joints = plant.num_positions() > sum(map(len, turns))
    if other_joints or deformables or not all(finger.is_anchored for finger in fingers):
        return
    reaches = _reaches(scene)
    pairs = scene_graph.model_inspector().GetCollisionCandidates()
    reachable_geometries = {geometry for pair in pairs if reaches[pair[0]].meets(reaches[pair[1]]) for geometry in pair}
    skins = (skin for finger in fingers for link in finger.links for skin in plant.GetCollisionGeometriesForBody(link))
    for idle in set(skins) - reachable_geometries:
        scene_graph.RemoveRole(plant.get_source_id(), idle, Role.kProximity)


def _reaches(scene: Scene) -> dict[GeometryId, _ReachBall]:
    """Reach of every collision geometry, where nothing moves but the joints of fingers."""
    plant = scene.plant
    inspector = scene.scene_graph.model_inspector()
    context = plant.CreateDefaultContext()
    reaches = {}
    links = {
        link.index(): (finger.base, begin)
        for finger in scene.fingers
        for link, begin in zip(finger.links, finger.finger.link_ends[:-1], strict=True)
    }
    for geometry in inspector.GetAllGeometryIds(Role.kProximity):
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
        box = inspector.GetObbInGeometryFrame(geometry)
        base, begin = links.get(body.index(), (body, 0.0))
        radius = np.inf  # of a half space, and of what a finger carries
        if box is not None and plant.IsAnchored(base):
            middle = inspector.GetPoseInFrame(geometry) @ box.center()
            radius = begin + float(np.linalg.norm(middle) + np.linalg.norm(box.half_width()))
        reaches[geometry] = _ReachBall(plant.EvalBodyPoseInWorld(context, base).translation(), radius)
    return reaches


MAX_RELATIVE_DEPTH = 0.1  # of the depth at which a compliant body is compressed to its middle
MAX_RIGID_DEPTH = 1e-3  # m, between two rigid bodies


def check_starts_apart(diagram: Diagram, scene_graph: SceneGraph, context: Context | None = None) -> None:
    """Checks the contacts of an initial state, in a context of the diagram; None: the default one.

    Raises:
        InputError: if bodies initially penetrate more deeply than a touch.
    """
    context = scene_graph.GetMyContextFromRoot(context or diagram.CreateDefaultContext())
    query = scene_graph.get_query_output_port().Eval(context)
    kind = HydroelasticContactRepresentation.kTriangle
    surfaces, point_pairs = query.ComputeContactSurfacesWithFallback(kind)
    inspector = query.inspector()
    deep_pairs = [(s.id_M(), s.id_N()) for s in surfaces if _depth(inspector, s) > MAX_RELATIVE_DEPTH]
    deep_pairs += [(pair.id_A, pair.id_B) for pair in point_pairs if pair.depth > MAX_RIGID_DEPTH]
    for pair in deep_pairs:
        first_name, second_name = (inspector.GetName(inspector.GetFrameId(id)) for id in pair)
        raise InputError(
            "models",
            "X_PC",
            first_name,
            f"begins inside '{second_name}'; move one of them away, or exclude links with `without`",
        )


def _depth(inspector: SceneGraphInspector, surface: ContactSurface) -> float:
    """Penetration of two bodies, as a fraction of the softer one's half thickness."""
    moduli = [
        inspector.GetProximityProperties(id).GetPropertyOrDefault("hydroelastic", "hydroelastic_modulus", float("inf"))
        for id in (surface.id_M(), surface.id_N())
    ]
    pressure = surface.tri_e_MN()
    return max(pressure.EvaluateAtVertex(v) for v in range(surface.num_vertices())) / min(moduli)
