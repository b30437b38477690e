"""A random arm, fixture or object whose mass and places are known, written as URDF, SDFormat and MJCF."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

Rng = np.random.Generator
Vector = NDArray[np.float64]
_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


@dataclass(frozen=True)
class Law:
    """How a joint follows another."""

    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Link:
    """A link, and the joint that holds it; text is added inside its elements."""

    name: str
    parent: str | None = None  # link
    kind: str = "fixed"  # revolute, continuous, prismatic or fixed, as in URDF
    xyz: Vector = field(default_factory=lambda: np.zeros(3))  # in the parent, at zero
    rpy: Vector = field(default_factory=lambda: np.zeros(3))
    axis: Vector = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    lower: float = -1.0
    upper: float = 1.0
    effort: float = 50.0
    velocity: float = 2.0
    law: Law | None = None
    mass: float = 1.0
    inertia: Vector = field(default_factory=lambda: 0.01 * np.eye(3))
    inside: str = ""  # the link
    in_joint: str = ""

    @property
    def joint(self) -> str:
        return f"to_{self.name}"

    @property
    def moves(self) -> bool:
        return self.kind != "fixed"

    def at(self, position: float) -> RigidTransform:
        """The pose in the parent."""
        place = RigidTransform(RollPitchYaw(self.rpy), self.xyz)
        unit = self.axis / np.linalg.norm(self.axis)
        if self.kind == "prismatic":
            return place @ RigidTransform(unit * position)
        turn = np.cross(np.eye(3), unit)  # the matrix of unit x
        return place @ RigidTransform(
            RotationMatrix(np.eye(3) + np.sin(position) * turn + (1 - np.cos(position)) * turn @ turn)
        )


def possible_inertia(rng: Rng, mass: float, size: float = 0.1) -> Vector:
    """The inertia of a body of three pairs of points at random places."""
    points = size * rng.uniform(-1, 1, (3, 3))
    moments = mass / 3 * points.T @ points
    return np.trace(moments) * np.eye(3) - moments


def chain(rng: Rng, kinds: tuple[str, ...] = ("revolute", "prismatic", "continuous", "fixed")) -> list[Link]:
    """Two to five links, of which one joint at least moves."""
    links = [Link("base", mass=float(rng.uniform(0.5, 3)), inertia=possible_inertia(rng, 2.0))]
    for i in range(int(rng.integers(1, 5))):
        mass = float(10 ** rng.uniform(-2, 1))
        kind = str(rng.choice(kinds)) if i else "revolute"
        turned = 0.0 if rng.random() < 0.3 else 1.0
        links.append(
            Link(
                name=f"l{i}",
                parent=links[-1 if rng.random() < 0.8 else 0].name,
                kind=kind,
                xyz=rng.uniform(-0.3, 0.3, 3).round(4),
                rpy=(turned * rng.uniform(-3, 3, 3)).round(4),
                axis=np.eye(3)[rng.integers(3)] if rng.random() < 0.5 else rng.uniform(-1, 1, 3).round(3) + 0.01,
                lower=round(float(rng.uniform(-2, -0.5)), 3),
                upper=round(float(rng.uniform(0.5, 2)), 3),
                effort=round(float(rng.uniform(5, 100)), 2),
                velocity=round(float(rng.uniform(1, 5)), 2),
                mass=mass,
                inertia=possible_inertia(rng, mass),
            )
        )
    return links


def positions(rng: Rng, links: list[Link]) -> dict[str, float]:
    """A position of each joint that moves; those that follow are where they must be."""
    found = {link.joint: float(rng.uniform(link.lower, link.upper)) for link in links if link.moves}
    laws = {link.joint: link.law for link in links if link.law is not None}
    for _ in laws:
        found |= {name: law.multiplier * found[law.leader] + law.offset for name, law in laws.items()}
    return found


def places(links: list[Link], at: Mapping[str, float], X_WB: RigidTransform) -> dict[str, RigidTransform]:
    """The poses of all links, from that of the first."""
    found = {links[0].name: X_WB}
    for link in links[1:]:
        assert link.parent is not None
        found[link.name] = found[link.parent] @ link.at(at.get(link.joint, 0.0))
    return found


def text(values: Vector) -> str:
    return " ".join(repr(float(value)) for value in values)


def urdf(links: list[Link], more: str = "", name: str = "m") -> str:
    """The text of a URDF file."""
    parts = [f'<robot name="{name}">', more]
    for link in links:
        entries = " ".join(f'{key}="{link.inertia[index]!r}"' for key, index in _ENTRIES.items())
        inertial = f'<inertial><mass value="{link.mass!r}"/><inertia {entries}/></inertial>'
        parts.append(f'<link name="{link.name}">{inertial}{link.inside}</link>')
    parts += [_urdf_joint(link) for link in links if link.parent is not None]
    return "\n".join([*parts, "</robot>"]).replace("np.float64(", "").replace(')"', '"')


def _urdf_joint(link: Link) -> str:
    ends = f'<parent link="{link.parent}"/><child link="{link.name}"/>'
    place = f'<origin xyz="{text(link.xyz)}" rpy="{text(link.rpy)}"/>'
    inside = f'<axis xyz="{text(link.axis)}"/>' if link.moves else ""
    if link.moves and "<limit" not in link.in_joint:
        ends_of_range = "" if link.kind == "continuous" else f'lower="{link.lower}" upper="{link.upper}" '
        inside += f'<limit {ends_of_range}effort="{link.effort}" velocity="{link.velocity}"/>'
    if link.law is not None:
        law = link.law
        inside += f'<mimic joint="{law.leader}" multiplier="{law.multiplier}" offset="{law.offset}"/>'
    return f'<joint name="{link.joint}" type="{link.kind}">{ends}{place}{inside}{link.in_joint}</joint>'


def sdf_model(links: list[Link], more: str = "", name: str = "m", version: str = "1.7") -> str:
    """The text of a <model>; `version` 1.4 has axes in the frame of the model, 1.5 may have them there."""
    at = places(links, {}, RigidTransform())
    parts = [f'<model name="{name}">', more]
    for link in links:
        X, entries = at[link.name], "".join(f"<{key}>{float(link.inertia[i])!r}</{key}>" for key, i in _ENTRIES.items())
        pose = f"<pose>{text(X.translation())} {text(RollPitchYaw(X.rotation()).vector())}</pose>"
        inertial = f"<inertial><mass>{link.mass!r}</mass><inertia>{entries}</inertia></inertial>"
        parts.append(f'<link name="{link.name}">{pose}{inertial}{link.inside}</link>')
    parts += [_sdf_joint(link, at[link.name], version) for link in links if link.parent is not None]
    return "\n".join([*parts, "</model>"])


def _sdf_joint(link: Link, X_ML: RigidTransform, version: str) -> str:
    in_model = version in ("1.4", "1.5")
    axis = X_ML.rotation() @ link.axis if in_model else link.axis
    mark = "<use_parent_model_frame>1</use_parent_model_frame>" if version == "1.5" else ""
    ends = f"<parent>{link.parent}</parent><child>{link.name}</child>"
    ends_of_range = "" if link.kind == "continuous" else f"<lower>{link.lower}</lower><upper>{link.upper}</upper>"
    limit = f"<limit>{ends_of_range}<effort>{link.effort}</effort><velocity>{link.velocity}</velocity></limit>"
    limit = "" if "<limit" in link.in_joint else limit
    law = link.law
    mimic = ""
    if law is not None:
        numbers = f"<multiplier>{law.multiplier}</multiplier><offset>{law.offset}</offset><reference>0</reference>"
        mimic = f'<mimic joint="{law.leader}">{numbers}</mimic>'
    inside = f"<axis><xyz>{text(axis)}</xyz>{mark}{limit}{mimic}{link.in_joint}</axis>" if link.moves else link.in_joint
    return f'<joint name="{link.joint}" type="{link.kind}">{ends}{inside}</joint>'


def sdf(links: list[Link], more: str = "", version: str = "1.7") -> str:
    """The text of an SDFormat file."""
    return f'<?xml version="1.0"?>\n<sdf version="{version}">\n{sdf_model(links, more, version=version)}\n</sdf>'


def mjcf_bodies(links: list[Link], radian: bool, name: str = "base") -> str:
    """The text of a <body> and of those that it holds."""
    link = next(link for link in links if link.name == name)
    w, x, y, z = RollPitchYaw(link.rpy).ToQuaternion().wxyz()
    full = text(np.array([link.inertia[index] for index in _ENTRIES.values()]))
    inertial = f'<inertial pos="0 0 0" mass="{link.mass!r}" fullinertia="{full}"/>'
    inertial = "" if "<geom" in link.inside or "<inertial" in link.inside else inertial
    unit = 1.0 if radian or link.kind == "prismatic" else 180 / np.pi
    ends = "" if link.kind == "continuous" else f' range="{float(unit * link.lower)!r} {float(unit * link.upper)!r}"'
    kind = "slide" if link.kind == "prismatic" else "hinge"
    joint = f'<joint name="{link.joint}" type="{kind}" axis="{text(link.axis)}"{ends} {link.in_joint}/>'
    inside = "".join(mjcf_bodies(links, radian, child.name) for child in links if child.parent == name)
    pose = f'pos="{text(link.xyz)}" quat="{text(np.array([w, x, y, z]))}"'
    return f'<body name="{name}" {pose}>{inertial}{joint if link.moves else ""}{link.inside}{inside}</body>\n'


def mjcf(links: list[Link], more: str = "", radian: bool = True, name: str = ' model="m"') -> str:
    """The text of an MJCF file."""
    angles = '<compiler angle="radian"/>' if radian else ""
    return f"<mujoco{name}>{angles}{more}\n<worldbody>\n{mjcf_bodies(links, radian)}</worldbody></mujoco>"


def changed(links: list[Link], name: str, **changes: object) -> list[Link]:
    """The same links but for one."""
    return [replace(link, **changes) if link.name == name else link for link in links]  # type: ignore[arg-type]
