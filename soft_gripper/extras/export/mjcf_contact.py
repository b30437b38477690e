"""Sets contacts of an exported scenario in MuJoCo: attributes of each shape, or pairs of two shapes.

Bits say which shapes may touch. MuJoCo mixes what two shapes say of their contact: it takes the larger friction, and
the mean of the time constants, weighted by `solmix`. Drake combines frictions to 2 a b / (a + b), and a contact of two
points of compliance c_1 and c_2, on bodies of mobility m_1 and m_2, has the time constant

    sqrt((c_1 + c_2) / ((1 - d) (m_1 + m_2))),

since MuJoCo takes the stiffness K of a contact of impedance d as an acceleration per penetration,
(1 - d) K (m_1 + m_2), where the mobility is its body_invweight0 (the documentation of MuJoCo, "Solver parameters": at
rest R f = -a_ref, with the regularisation R = (1 - d) / d times that sum). Its integrator `discrete` divides R by what
springs and dampers take from the mobility within a step: there, mobilities are those within a step.

Skins that say sqrt(c / ((1 - d) m)), with the weight m^(3/4) c^(1/4), mix to this value within 0.3 % for moving links
of fingers. A rigid shape has no weight, so that a skin on it has the time constant of the skin, and says the friction
of a skin on it, which is right where it is the larger one. A pair of shapes is listed only if its friction or stiffness
would be mixed wrong, or if it is asked for: only a pair has a time constant of friction. With that of its normal force,
10 to 90 ms, what an arm turns with speed w at a distance r slides at w^2 r times half of it, since MuJoCo leaves out
the centripetal part of the acceleration of a contact.
"""

from collections.abc import Container, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.extras.export.tree import text
from soft_gripper.truth.contact import combined_friction

IMPEDANCE = 0.95  # d of a contact with a skin
_RIGID_TIME = 0.004  # s, time constant of a contact without one; with MuJoCo's 0.02 s light links sink in
# Largest relative differences of stiffness that need no pair: of a skin on a rigid shape, and of two skins, which is
# reached where the link of one is fixed.
_RIGID_TOLERANCE, _SKINS_TOLERANCE = 0.01, 0.2
_FIXED_SKIN_MOBILITY = 0.05  # assumed for a fixed skin, of the usual mobility
_MASK_BITS = 31  # of a mask
_PATCH_RADIUS = 4e-3  # m, radius over which a link touches, shared by its points; 35 to 90 mm^2 in the shipped grasps


class ShapeSurface(NamedTuple):
    """Properties of a shape that determine its contacts."""

    friction: float
    compliance: float  # of a point, m/N; 0 if it is rigid
    mobility: float  # of its body, 1/kg


class DampedContact(NamedTuple):
    """A contact, critically damped."""

    friction: float
    time: float  # constant, s


def touch(first: ShapeSurface, second: ShapeSurface) -> DampedContact:
    """The contact of two surfaces as in Drake."""
    compliance, mobility = first.compliance + second.compliance, first.mobility + second.mobility
    return DampedContact(combined_friction(first.friction, second.friction), _time_constant(compliance, mobility))


class Skin(NamedTuple):
    """Contact properties of a finger's skin."""

    friction: float
    mobility: float  # 1/kg


class StatedContact(NamedTuple):
    """Attributes of a shape that state its contacts."""

    touch: DampedContact
    weight: float  # of its time constant


def stated_contact(surface: ShapeSurface, skin: Skin) -> StatedContact:
    """Attributes of a shape where the usual skin touches it."""
    if surface.compliance == 0:
        return StatedContact(DampedContact(combined_friction(surface.friction, skin.friction), _RIGID_TIME), 0.0)
    mobility = max(surface.mobility, _FIXED_SKIN_MOBILITY * skin.mobility)
    weight = mobility**0.75 * surface.compliance**0.25
    return StatedContact(DampedContact(surface.friction, _time_constant(surface.compliance, mobility)), weight)


def mixed(first: StatedContact, second: StatedContact) -> DampedContact:
    """The contact that MuJoCo mixes from the attributes of two shapes."""
    share = 0.5 if first.weight == second.weight else first.weight / (first.weight + second.weight)
    time = share * first.touch.time + (1 - share) * second.touch.time
    return DampedContact(max(first.touch.friction, second.touch.friction), time)


def usual_skin(surfaces: Sequence[ShapeSurface]) -> Skin:
    """Medians of the properties of all skins."""
    skins = [Skin(surface.friction, surface.mobility) for surface in surfaces if surface.compliance > 0]
    return Skin(*np.median(skins, axis=0).tolist()) if skins else Skin(1.0, 0.0)


def has_same_contact(target: DampedContact, contact: DampedContact, tolerance: float) -> bool:
    """Whether two contacts have the same friction, and a stiffness that differs by a fraction of less than this."""
    is_stiff = abs((target.time / contact.time) ** 2 - 1) < tolerance
    return is_stiff and abs(target.friction - contact.friction) < 1e-9


def masks(may_touch: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Bits contype and conaffinity of shapes, (G, 2), for the pairs that may touch, (G, G).

    Shapes that touch the same others share a bit; shapes for which none is left have none.
    """
    _, group = np.unique(may_touch, axis=0, return_inverse=True)
    bits = np.where(group < _MASK_BITS, 1 << np.minimum(group, _MASK_BITS), 0)
    affinity = np.array([np.bitwise_or.reduce(bits[row], initial=0) for row in may_touch], dtype=int)
    return np.stack([bits, np.where(bits > 0, affinity, 0)], axis=-1)


class ContactSettings(NamedTuple):
    """Contacts of G shapes, as attributes of MJCF."""

    geoms: list[dict[str, str]]  # (G,)
    pairs: dict[tuple[int, int], dict[str, str]]  # by the numbers of both shapes


def contact_settings(
    surfaces: Sequence[ShapeSurface],
    candidates: Sequence[tuple[int, int]],
    filtered: Container[tuple[int, int]],
    points: int,
    step: float,
    listed: Container[int] = (),
) -> ContactSettings:
    """Attributes of the contacts of shapes.

    Args:
        surfaces: of the shapes, (G,).
        candidates: the numbers of those that may touch.
        filtered: candidates that touch in MuJoCo only as a pair.
        points: on either side of a link, which share its patch.
        step: s, in which friction in a pair stops what slides.
        listed: shapes that touch in pairs only.
    """
    may_touch = np.zeros((len(surfaces), len(surfaces)), dtype=bool)
    for i, j in candidates:
        may_touch[i, j] = may_touch[j, i] = True
    bits = masks(may_touch).tolist()
    skin = usual_skin(surfaces)
    shapes = [stated_contact(surface, skin) for surface in surfaces]
    geoms = []
    pairs = {}
    for surface, shape, (contype, conaffinity) in zip(surfaces, shapes, bits, strict=True):
        settings = {"contype": str(contype), "conaffinity": str(conaffinity), "solmix": repr(shape.weight)}
        geoms.append(settings | _attributes(shape.touch, surface.compliance > 0, 1, points))
    pair_attributes = cache(partial(_pair_attributes, points=points))  # many shapes are alike
    shortest_time = {"solreffriction": text([2 * step, 1])}  # the shortest time constant that MuJoCo takes
    for i, j in candidates:
        is_mixed, attributes = pair_attributes(surfaces[i], surfaces[j], shapes[i], shapes[j])
        is_alone = (i, j) in filtered or not (bits[i][0] and bits[j][0])
        if not is_mixed or is_alone or i in listed or j in listed:
            pairs[i, j] = attributes | shortest_time
    return ContactSettings(geoms, pairs)


def _pair_attributes(
    first: ShapeSurface, second: ShapeSurface, *shapes: StatedContact, points: int
) -> tuple[bool, dict[str, str]]:
    """Whether MuJoCo mixes the attributes of two shapes to their right contact, and this as attributes of a pair."""
    target = touch(first, second)
    skins = (first.compliance > 0) + (second.compliance > 0)
    is_mixed = has_same_contact(target, mixed(*shapes), _SKINS_TOLERANCE if skins == 2 else _RIGID_TOLERANCE)
    return is_mixed, _attributes(target, skins > 0, 2, points)


def friction_coefficients(contact: DampedContact, directions: int, points: int) -> list[float]:
    """Coefficients of friction of a contact in MuJoCo: sliding in `directions` directions, turning and rolling.

    A contact resists turning as pressure that is even over a patch does.
    """
    torsion = 2 / 3 * _PATCH_RADIUS / np.sqrt(points) * contact.friction
    return [*[contact.friction] * directions, float(torsion), *[1e-4] * directions]


def _attributes(contact: DampedContact, is_skin: bool, directions: int, points: int) -> dict[str, str]:
    """Attributes of a contact; the contact of a skin resists turning too."""
    friction = friction_coefficients(contact, directions, points)
    settings = {"friction": text(friction), "solref": text([contact.time, 1]), "condim": "4" if is_skin else "3"}
    return settings | ({"solimp": text([IMPEDANCE, IMPEDANCE, 1e-3, 0.5, 2])} if is_skin else {})


def _time_constant(compliance: float, mobility: float) -> float:
    """Time constant, s."""
    return float(np.sqrt(compliance / (1 - IMPEDANCE) / mobility)) if compliance > 0 else _RIGID_TIME
