"""Models as other people write them, of every kind, each with what is right about it."""

import io
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import trimesh
from model_chain import Law, Link, Rng, chain, changed, mjcf, mjcf_bodies, places, sdf, sdf_model, text, urdf
from pydrake.math import RigidTransform, RollPitchYaw


@dataclass
class Model:
    """A file, those that it names, and what is right."""

    content: str
    suffix: str
    links: list[Link]  # their joints, masses and places
    files: dict[str, bytes] = field(default_factory=dict)
    notes: set[str] = field(default_factory=set)  # outcome and element, exactly those of all notes
    is_arm: bool = False
    free: bool = False
    base: RigidTransform = field(default_factory=RigidTransform)  # of the first link where the file puts it
    stays: bool = False  # the scenario does not say where it stands
    volumes: list[float] = field(default_factory=list)  # of the shapes that touch, m^3
    refused: tuple[str, ...] = ()  # words of the refusal
    prefix: dict[str, str] = field(default_factory=dict)  # names of links and joints that become others
    more_mass: float = 0.0


def follows(links: list[Link]) -> set[str]:
    return {f"read joint '{link.joint}'" for link in links if link.law is not None}


def _written(rng: Rng, links: list[Link], more: str = "") -> tuple[str, str]:
    """In URDF or SDFormat."""
    return (urdf(links, more), "urdf") if rng.random() < 0.5 else (sdf(links, more), "sdf")


def plain(rng: Rng) -> Model:
    """Nothing special, as arm, fixture and object, in three formats."""
    links = chain(rng)
    form = rng.integers(3)
    if form == 2:
        return Model(mjcf(links, radian=bool(rng.integers(2))), "xml", links, stays=True)
    content, suffix = _written(rng, links)
    role = rng.integers(3)
    return Model(content, suffix, links, is_arm=role == 1, free=role == 2)


def fixed_axes(rng: Rng) -> Model:
    """Axes, limits and couplings of joints that do not move."""
    links, suffix = chain(rng), str(rng.choice(["urdf", "sdf"]))
    still = Link("still", "base", inside="", xyz=np.array([0.1, 0, 0]))
    junk = {
        "urdf": [
            '<axis xyz="0 0 0"/>',
            '<axis xyz="nan x"/>',
            "<axis/>",
            '<limit effort="0" velocity="no" lower="9" upper="-9"/>',
            '<dynamics damping="much"/><mimic joint="nosuch" multiplier="x"/>',
            '<calibration rising="0"/>',
        ],
        "sdf": [
            "<axis><xyz>0 0 0</xyz></axis>",
            "<axis><xyz>a b</xyz></axis>",
            "<axis><xyz>0 0 0</xyz><limit><lower>no</lower></limit></axis>",
        ],
    }[suffix]
    links = [*links, replace(still, in_joint=str(rng.choice(junk)))]
    return Model((urdf if suffix == "urdf" else sdf)(links), suffix, links, is_arm=bool(rng.integers(2)))


def other_programs(rng: Rng) -> Model:
    """Elements of Gazebo, ROS and others, with prefixes that nobody declares, and comments that XML forbids."""
    links, notes = chain(rng), set()
    inside = ["<!-- a -- b -->", "<!-- <link/> -->"]
    content, suffix = _written(rng, links)
    if suffix == "urdf":
        junk = {
            '<gazebo reference="l0"><gz:x y="1"/><mass value="much"/></gazebo>': "left out <gazebo> of 'l0'",
            "<gazebo><plugin name='p' filename='q.so'><a:b/></plugin></gazebo>": "left out <gazebo> of 'm'",
            '<ros2_control name="r" type="system"><hardware/></ros2_control>': "left out <ros2_control> of 'r'",
            '<xacro:property name="pi" value="3"/>': None,
            '<self_collision_checking name="s"/>': "left out <self_collision_checking> of 's'",
        }
    else:
        junk = {
            '<plugin name="p" filename="q.so"><pose>much</pose></plugin>': "left out <plugin> of 'p'",
            '<sensor name="s" type="camera"><pose>x</pose></sensor>': "left out <sensor> of 's'",
            '<battery name="b"><voltage>x</voltage></battery>': "left out <battery> of 'b'",
        }
    for some in rng.choice(list(junk), size=int(rng.integers(1, len(junk) + 1)), replace=False):
        inside.append(str(some))
        notes |= {said} if (said := junk[str(some)]) else set()
    content = (urdf if suffix == "urdf" else sdf)(links, "\n".join(map(str, rng.permutation(inside))))
    if rng.random() < 0.3:
        content = content.replace('<robot name="m">', '<robot xmlns="http://www.ros.org" name="m">')
    if rng.random() < 0.3:
        content = f"\n {content}"
    return Model(content, suffix, links, notes=notes, is_arm=bool(rng.integers(2)))


_FORMATS = ("stl", "dae", "ply", "obj", "stl_ascii", "glb")


def _exported(mesh: trimesh.Trimesh, form: str) -> bytes:
    content = mesh.export(file_type=form)
    return content if isinstance(content, bytes) else content.encode()


def _shape(rng: Rng) -> trimesh.Trimesh:
    size = rng.uniform(0.02, 0.2, 3)
    made = (
        trimesh.creation.box(size),
        trimesh.creation.icosphere(1, float(size[0])),
        trimesh.creation.cylinder(float(size[0]), float(size[1]), sections=12),
    )
    return made[rng.integers(3)]


def _named(suffix: str, uri: str, kinds: tuple[str, ...] = ("visual", "collision"), inside: str = "") -> str:
    mesh = f'<mesh filename="{uri}"/>' if suffix == "urdf" else f"<mesh><uri>{uri}</uri></mesh>"
    return "".join(f'<{kind} name="{kind}"><geometry>{mesh}</geometry>{inside}</{kind}>' for kind in kinds)


def meshes(rng: Rng) -> Model:
    """Shapes in any format of meshes, beside the file or in a package."""
    links, mesh, form = chain(rng), _shape(rng), str(rng.choice(_FORMATS))
    suffix = str(rng.choice(["urdf", "sdf"]))
    file = f"shape.{form.partition('_')[0]}"
    way = rng.integers(4)
    folder, uri = [
        ("", file),
        ("meshes/", f"meshes/{file}"),
        ("package/meshes/", f"package://package/meshes/{file}"),
        ("package/", f"model://package/{file}"),
    ][way]
    if form == "glb":
        mesh.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, [1, 0, 0]))
    links = changed(links, "l0", inside=_named(suffix, uri), inertia=0.001 * np.eye(3), mass=1.0)
    content = (urdf if suffix == "urdf" else sdf)(links)
    is_arm = bool(rng.integers(2))
    volume = [abs(mesh.convex_hull.volume)]
    return Model(content, suffix, links, {folder + file: _exported(mesh, form)}, is_arm=is_arm, volumes=volume)


def inertias(rng: Rng) -> Model:
    """Inertias that no body has, and none at all."""
    links = chain(rng, ("revolute", "prismatic", "continuous"))
    form = str(rng.choice(["urdf", "sdf", "xml"]))
    wrong = rng.integers(3)
    notes = set()
    if wrong == 0:
        inertia = np.diag(rng.permutation([5.0, 0.1, 0.1])) * links[1].mass * 1e-3
        notes = {"mended link 'l0': inertia ixx, iyy, izz"} if form != "xml" else {"mended body 'l0': inertia"}
        links = changed(links, "l0", inertia=inertia)
    elif wrong == 1:
        links = changed(links, "l0", inertia=np.zeros((3, 3)))
        notes = {"mended link 'l0': inertia ixx, iyy, izz"} if form != "xml" else {"mended body 'l0': inertia"}
    else:
        links = changed(links, "l0", inertia=np.zeros((3, 3)), mass=0.0)
        notes = {"mended link 'l0': mass"} if form != "xml" else {"mended body 'l0': mass"}
    writer: dict[str, Callable[[list[Link]], str]] = {"urdf": urdf, "sdf": sdf, "xml": mjcf}
    content = writer[form](links)
    more = 1e-3 if wrong == 2 else 0.0  # such a link weighs 1 g
    return Model(content, form, links, notes=notes, stays=form == "xml", more_mass=more)


def massless_ends(rng: Rng) -> Model:
    """Links without mass that are fixed to something, such as frames of tools."""
    links = chain(rng)
    links = [*links, Link("tool", links[-1].name, xyz=np.array([0, 0, 0.1]), mass=0.0, inertia=np.zeros((3, 3)))]
    form = str(rng.choice(["urdf", "sdf", "xml"]))
    writer: dict[str, Callable[[list[Link]], str]] = {"urdf": urdf, "sdf": sdf, "xml": mjcf}
    is_arm = form != "xml" and bool(rng.integers(2))
    return Model(writer[form](links), form, links, is_arm=is_arm, stays=form == "xml")


def massless_joints(rng: Rng) -> Model:
    """Links without mass that move and carry one that has a mass, and free objects whose first link has none."""
    links, form = chain(rng, ("revolute", "prismatic")), str(rng.choice(["urdf", "sdf"]))
    name = "base" if rng.random() < 0.5 else "l0"
    links = changed(links, name, mass=0.0, inertia=np.zeros((3, 3)))
    is_carrier = bool(rng.integers(2))
    links = [*links, Link("load", name, xyz=rng.uniform(-0.1, 0.1, 3))] if is_carrier else links
    notes = set() if is_carrier else {f"mended link '{name}': mass"}
    content, more = (urdf if form == "urdf" else sdf)(links), 0.0 if is_carrier else 1e-3
    return Model(content, form, links, notes=notes, free=name == "base", more_mass=more)


def shapes_without_size(rng: Rng) -> Model:
    """Boxes, balls and cylinders that have no size, and such as have nearly none."""
    tag = str(rng.choice(["box", "sphere", "cylinder"]))
    zero, small = str(rng.choice(["0", "0.0", "-0"])), "1e-7"
    form = str(rng.choice(["urdf", "sdf"]))

    def shape(size: str) -> str:
        sizes = {"box": {"size": " ".join(3 * [size])}, "sphere": {"radius": size}}
        values = sizes.get(tag, {"radius": size, "length": size})
        attributes = "".join(f' {key}="{value}"' for key, value in values.items())
        children = "".join(f"<{key}>{value}</{key}>" for key, value in values.items())
        geometry = f"<{tag}{attributes}/>" if form == "urdf" else f"<{tag}>{children}</{tag}>"
        return f"<geometry>{geometry}</geometry>"

    kind = str(rng.choice(["visual", "collision"]))
    inside = f'<{kind} name="a">{shape(zero)}</{kind}><visual name="b">{shape(small)}</visual>'
    links = changed(chain(rng), "l0", inside=inside)
    notes = {f"left out link 'l0': {kind}", "read link 'l0': inertia"}
    return Model((urdf if form == "urdf" else sdf)(links), form, links, notes=notes)


def absurd_limits(rng: Rng) -> Model:
    """Limits so far away that they limit nothing."""
    links = chain(rng, ("revolute", "prismatic"))
    far = str(rng.choice(["1e16", "1e300", "inf", "1e15"]))
    limit = f'<limit lower="-{far}" upper="{far}" effort="50" velocity="2"/>'
    links = changed(links, "l0", in_joint=limit, effort=50.0)
    return Model(urdf(links), "urdf", links, is_arm=bool(rng.integers(2)))


def transmissions(rng: Rng) -> Model:
    """Transmissions of other kinds, of the same names, and with reductions."""
    links = chain(rng, ("revolute", "prismatic"))
    kind = "transmission_interface/SimpleTransmission"
    reduction = "<mechanicalReduction>50</mechanicalReduction>" if rng.random() < 0.5 else ""
    parts = [
        f'<transmission name="t{i}"><type>{kind}</type><joint name="{link.joint}"/><actuator name="a">{reduction}'
        f"</actuator></transmission>"
        for i, link in enumerate(link for link in links if link.moves)
    ]
    is_arm, notes = bool(rng.integers(2)), set()
    if is_arm and reduction:
        notes = {"left out <transmission> 't0': mechanicalReduction"}
    elif not is_arm:
        notes = {f"left out <transmission> 't{i}'" for i in range(1, len(parts))}
        notes |= {"read <mechanicalReduction>"} if reduction else set()
    return Model(urdf(links, "".join(parts)), "urdf", links, notes=notes, is_arm=is_arm)


def not_in_sdf(rng: Rng) -> Model:
    """Elements and attributes that SDFormat does not have, but other programs read."""
    box = "<geometry><box><size>0.1 0.1 0.1</size></box></geometry>"
    inside = (
        f'<contact><lateral_friction>1</lateral_friction></contact><collision name="c" concave="yes">{box}</collision>'
    )
    links = changed(chain(rng), "l0", inside=inside, mass=1.0, inertia=1e-3 * np.eye(3))
    notes = {"left out <contact> of 'l0'", "left out collision 'c': concave"}
    return Model(sdf(links), "sdf", links, notes=notes, is_arm=bool(rng.integers(2)))


def seams(rng: Rng) -> Model:
    """A bare mesh whose vertices are split at seams, as textures and sharp edges have them; perhaps inside out."""
    mesh = _shape(rng)
    triangles = mesh.triangles[rng.permutation(len(mesh.faces))]
    notes = set()
    if rng.random() < 0.4:
        triangles, notes = triangles[:, ::-1], {"mended the mesh"}
    split = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), process=False)
    form = str(rng.choice(["obj", "ply", "off", "stl"]))
    link = Link("thing", mass=0.05)
    bare = Model("", form, [link], {f"model.{form}": _exported(split, form)}, notes=notes, free=True)
    return replace(bare, volumes=[mesh.volume])


def inside_out(rng: Rng) -> Model:
    """Two closed parts of a surface that touches, of which one or both are inside out."""
    parts = [trimesh.creation.box((0.05, 0.04, 0.06)), trimesh.creation.box((0.03, 0.02, 0.02))]
    parts[1].apply_translation([0.2, 0, 0])
    volume = sum(part.volume for part in parts)
    turned = rng.integers(3)  # the small one, the large one, both
    for part in [parts[1]] if turned == 0 else [parts[0]] if turned == 1 else parts:
        part.invert()
    notes = {"mended part 0"} if turned == 1 else {"mended part 1"} if turned == 0 else {"mended the mesh"}
    if turned == 1:  # the whole is turned first, since its volume is negative, and then the other part
        notes = {"mended the mesh", "mended part 1"}
    mesh = trimesh.util.concatenate(parts)
    suffix = str(rng.choice(["urdf", "sdf"]))
    links = changed(
        chain(rng), "l0", inside=_named(suffix, "shape.obj", ("collision",)), inertia=0.001 * np.eye(3), mass=1.0
    )
    content = (urdf if suffix == "urdf" else sdf)(links)
    return Model(content, suffix, links, {"shape.obj": _exported(mesh, "obj")}, notes=notes, volumes=[volume])


def world_joints(rng: Rng) -> Model:
    """Models that their own files join to the world, by a joint that moves or not, or by being static."""
    links = chain(rng)
    base = RigidTransform(RollPitchYaw(rng.uniform(-1, 1, 3)), rng.uniform(-1, 1, 3))
    xyz, rpy = base.translation(), RollPitchYaw(base.rotation()).vector()
    way, free = rng.integers(4), bool(rng.random() < 0.3)
    notes = {"left out joint 'to_world'"} if free else set()
    origin = f'<origin xyz="{text(xyz)}" rpy="{text(rpy)}"/>'
    ends = '<parent link="world"/><child link="base"/>'
    joint = f'<joint name="to_world" type="fixed">{ends}{origin}</joint>'
    if way == 0:
        content, suffix = urdf(links, joint), "urdf"
    elif way == 1:
        content, suffix = urdf(links, f'<link name="world"/>{joint}'), "urdf"
    elif way == 2:
        in_sdf = '<joint name="to_world" type="fixed"><parent>world</parent><child>base</child></joint>'
        content, suffix = sdf(links, in_sdf), "sdf"
        base = RigidTransform()
    else:
        content, suffix, base = sdf(links, "<static>true</static>"), "sdf", RigidTransform()
        notes = {"left out joint 'base_to_world'"} if free else set()
        if not free:  # every joint of a static model stays as it is
            return Model(content, suffix, links, notes=notes)
    if free:
        base = RigidTransform()
    return Model(content, suffix, links, notes=notes, free=free, base=base)


def couplings(rng: Rng) -> Model:
    """Joints that follow others, in chains, in three formats."""
    links = chain(rng, ("revolute", "prismatic"))
    while sum(link.moves for link in links) < 2:
        links = chain(rng, ("revolute", "prismatic"))
    moving = [link.name for link in links if link.moves]
    for before, name in pairwise(moving):
        if rng.random() < 0.7 or name == moving[1]:
            law = Law(f"to_{before}", round(float(rng.uniform(-2, 2)), 3), round(float(rng.uniform(-0.3, 0.3)), 3))
            links = changed(links, name, law=law, lower=-2e3, upper=2e3)
    form = str(rng.choice(["urdf", "sdf", "xml"]))
    notes = follows(links)
    if form != "xml":
        is_arm = bool(rng.integers(2))
        return Model((urdf if form == "urdf" else sdf)(links), form, links, notes=notes, is_arm=is_arm)
    laws = "".join(_equality(link, link.law) for link in links if link.law is not None)
    return Model(mjcf(links, f"<equality>{laws}</equality>"), "xml", links, notes=notes, stays=True)


def _equality(link: Link, law: Law) -> str:
    return f'<joint joint1="{link.joint}" joint2="{law.leader}" polycoef="{law.offset} {law.multiplier} 0 0 0"/>'


def no_limits(rng: Rng) -> Model:
    """Joints without end, and without limits of velocity and effort, in SDFormat and in what is not an arm."""
    links = changed(chain(rng, ("revolute",)), "l0", kind="continuous", lower=-3.0, upper=3.0, in_joint="<limit/>")
    is_arm = bool(rng.integers(2))
    notes = {f"read joint 'to_l0': limit.{name}" for name in ("effort", "velocity")} if is_arm else set()
    return Model(sdf(links), "sdf", links, notes=notes, is_arm=is_arm)


def friction(rng: Rng) -> Model:
    """Friction in joints, which Drake does not have, and damping, which it has."""
    links = chain(rng, ("revolute", "prismatic"))
    form, value = str(rng.choice(["urdf", "sdf"])), round(float(rng.uniform(0.1, 5)), 2)
    inside = f'<dynamics damping="0.3" friction="{value}"/>'
    if form == "sdf":
        inside = f"<dynamics><damping>0.3</damping><friction>{value}</friction></dynamics>"
    links = changed(links, "l0", in_joint=inside)
    content = (urdf if form == "urdf" else sdf)(links)
    return Model(
        content, form, links, notes={"left out joint 'to_l0': dynamics.friction"}, is_arm=bool(rng.integers(2))
    )


def colors(rng: Rng) -> Model:
    """Materials that are named once, twice, never, or with a texture only."""
    box = '<geometry><box size="0.1 0.1 0.1"/></geometry>'
    way = rng.integers(4)
    more = '<material name="red"><color rgba="1 0 0 1"/></material>' if way != 2 else ""
    used = [
        '<material name="red"/>',
        '<material name="red"><color rgba="0 1 0 1"/></material>',
        '<material name="red"/>',
        '<material name="wood"><texture filename="wood.png"/></material>',
    ][way]
    links = changed(chain(rng), "l0", inside=f"<visual>{box}{used}</visual>", inertia=0.001 * np.eye(3), mass=1.0)
    notes = {"left out link 'l0': material"} if way >= 2 else set()
    return Model(urdf(links, more), "urdf", links, notes=notes, is_arm=bool(rng.integers(2)))


def nested(rng: Rng) -> Model:
    """SDFormat models in models, in the file or included, each with a pose, perhaps of an older version."""
    inner = chain(rng, ("revolute", "prismatic", "fixed"))
    is_included, version = bool(rng.integers(2)), "1.7"
    X = RigidTransform(RollPitchYaw(rng.uniform(-1, 1, 3).round(3)), rng.uniform(-1, 1, 3).round(3))
    pose = f"<pose>{text(X.translation())} {text(RollPitchYaw(X.rotation()).vector())}</pose>"
    joint = '<joint name="hold" type="fixed"><parent>base</parent><child>hand::base</child></joint>'
    outer = Link("base", mass=2.0)
    files = {}
    if is_included:
        version = str(rng.choice(["1.4", "1.5", "1.7", "1.9"]))
        folder = bool(rng.integers(2))
        file = "hand/model.sdf" if folder else "hand.sdf"
        files[file] = f'<sdf version="{version}">{sdf_model(inner, version=version)}</sdf>'.encode()
        if folder:
            files["hand/model.config"] = b'<model><name>hand</name><sdf version="1.7">model.sdf</sdf></model>'
        uri = str(rng.choice(["hand", "model://hand"])) if folder else file
        inside = f"<include><uri>{uri}</uri><name>hand</name>{pose}</include>"
    else:
        inside = sdf_model(inner, pose, "hand")
    content = f'<sdf version="1.7">{sdf_model([outer], f"{inside}{joint}")}</sdf>'
    names = {link.name: f"hand_{link.name}" for link in inner} | {link.joint: f"hand_{link.joint}" for link in inner}
    renamed = [
        replace(link, name=names[link.name], parent="base" if link.parent is None else names[link.parent])
        for link in inner
    ]
    first = replace(renamed[0], xyz=X.translation(), rpy=RollPitchYaw(X.rotation()).vector())
    joints = {f"to_hand_{link.name}": f"hand_{link.joint}" for link in inner}
    return Model(content, "sdf", [outer, first, *renamed[1:]], files, prefix=joints, is_arm=bool(rng.integers(2)))


def included_whole(rng: Rng) -> Model:
    """A file that includes nothing but a model, or a world with one, mended as if it were that model."""
    links = chain(rng, ("revolute", "prismatic"))
    links = changed(links, "l0", in_joint="<dynamics><friction>1</friction></dynamics>")
    include = "<include><uri>arm.sdf</uri></include>"
    inside = include if rng.random() < 0.5 else f'<world name="w">{include}</world>'
    files = {"arm.sdf": sdf(links).encode()}
    notes = {"left out joint 'to_l0': dynamics.friction"}
    is_arm = bool(rng.integers(2))
    return Model(f'<sdf version="1.7">{inside}</sdf>', "sdf", links, files, notes=notes, is_arm=is_arm)


def bad_includes(rng: Rng) -> Model:
    """Includes of nothing, of themselves, and of what is not a model, in SDFormat and MJCF."""
    links = chain(rng)
    files = {"empty.sdf": b'<sdf version="1.7"/>', "folder/x": b"", "text.sdf": b"x", "loop.xml": b""}
    files["loop.xml"] = b'<mujocoinclude><include file="loop.xml"/></mujocoinclude>'
    if rng.random() < 0.5:
        uri = str(rng.choice(["none.sdf", "model.sdf", "empty.sdf", "text.sdf", "folder", "model://none"]))
        include = f"<include><uri>{uri}</uri></include>"
        return Model(sdf(links, include), "sdf", links, files, refused=(uri.rpartition("/")[2],))
    file = str(rng.choice(["none.xml", "loop.xml"]))
    return Model(mjcf(links, f'<include file="{file}"/>'), "xml", links, files, refused=("model.xml", "include", file))


def frames(rng: Rng) -> Model:
    """SDFormat links whose poses are given in frames, other links and joints."""
    links, at = chain(rng, ("revolute", "prismatic")), {}
    content = sdf(links)
    at = places(links, {}, RigidTransform())
    for i, link in enumerate(links[1:]):
        X = at[link.name]
        absolute = f"<pose>{text(X.translation())} {text(RollPitchYaw(X.rotation()).vector())}</pose>"
        in_parent = f"{text(link.xyz)} {text(link.rpy)}"
        if rng.random() < 0.5:
            other = f'<pose relative_to="{link.parent}">{in_parent}</pose>'
        else:
            frame = f'<frame name="f{i}" attached_to="{link.parent}"><pose>{in_parent}</pose></frame>'
            content = content.replace("</model>", f"{frame}</model>")
            other = f'<pose relative_to="f{i}"/>'
        content = content.replace(f'name="{link.name}">{absolute}', f'name="{link.name}">{other}')
    return Model(content, "sdf", links, is_arm=bool(rng.integers(2)))


def mjcf_arms(rng: Rng) -> Model:
    """MJCF arms with actuators of every kind, classes, gears and ranges."""
    links, notes, actuators = chain(rng, ("revolute", "prismatic")), set(), []
    for link in [link for link in links if link.moves]:
        kind, gear = str(rng.choice(["motor", "position", "general", "velocity"])), round(float(rng.uniform(1, 9)), 2)
        most = round(float(rng.uniform(1, 20)), 2)
        ranges = f'forcerange="-{most} {most}"'
        if kind == "motor" and rng.random() < 0.5:
            ranges = f'ctrllimited="true" ctrlrange="-{most} {most}"'
        in_class = rng.random() < 0.4
        limits = f'class="{link.name}"' if in_class else ranges
        klass = f'<default><default class="{link.name}"><{kind} {ranges}/></default></default>' if in_class else ""
        actuators.append(
            f'{klass}<actuator><{kind} name="a_{link.name}" joint="{link.joint}" gear="{gear}" {limits}/></actuator>'
        )
        links = changed(links, link.name, effort=gear * most)
        notes |= {f"read actuator 'a_{link.name}'"} if kind != "motor" else set()
        notes |= {f"read joint '{link.joint}': limit.velocity"}
    return Model(mjcf(links, "".join(actuators)), "xml", links, notes=notes, is_arm=True, stays=True)


def mjcf_files(rng: Rng) -> Model:
    """MJCF in several files, without a name, with meshes in folders, and masses from geoms of some groups."""
    links, mesh = chain(rng, ("revolute", "prismatic")), _shape(rng)
    density = 1000.0
    form = str(rng.choice(["stl", "obj", "msh"]))
    content = _msh(mesh) if form == "msh" else _exported(mesh, form)
    named = '<geom name="g" class="c" group="1"/><geom type="box" size="1 1 1" group="3" contype="0" conaffinity="0"/>'
    links = changed(links, "l0", inside=named, mass=density * mesh.volume)
    folder = str(rng.choice(["", "parts/"]))
    where = rng.choice(["meshdir", "assetdir"])
    compiler = f'<compiler angle="radian" inertiagrouprange="0 2" {where}="{folder}"/>'
    asset = f'<asset><mesh name="shape" file="shape.{form}"/></asset>'
    default = '<default><default class="c"><geom type="mesh" mesh="shape"/></default></default>'
    body = mjcf_bodies(links, True)
    files = {f"{folder}shape.{form}": content}
    if rng.random() < 0.5:
        files["body.xml"] = f"<mujocoinclude>{body}</mujocoinclude>".encode()
        body = '<include file="body.xml"/>'
    if rng.random() < 0.5:
        files["assets.xml"] = f"<mujocoinclude>{asset}{default}</mujocoinclude>".encode()
        asset, default = '<include file="assets.xml"/>', ""
    name = ' model="m"' if rng.random() < 0.5 else ""
    content_of_main = f"<mujoco{name}>{compiler}{asset}{default}<worldbody>{body}</worldbody></mujoco>"
    return Model(content_of_main, "xml", links, files, stays=True)


def _msh(mesh: trimesh.Trimesh) -> bytes:
    out = io.BytesIO()
    out.write(np.array([len(mesh.vertices), 0, 0, len(mesh.faces)], "<i4").tobytes())
    out.write(np.asarray(mesh.vertices, "<f4").tobytes() + np.asarray(mesh.faces, "<i4").tobytes())
    return out.getvalue()


KINDS: dict[str, Callable[[Rng], Model]] = {
    kind.__name__.replace("_", " "): kind
    for kind in (
        *(plain, fixed_axes, other_programs, meshes, inertias, massless_ends, massless_joints, seams, inside_out),
        *(world_joints, couplings, no_limits, friction, colors),
        *(shapes_without_size, absurd_limits, transmissions, not_in_sdf),
        *(nested, included_whole, bad_includes, frames, mjcf_arms, mjcf_files),
    )
}
