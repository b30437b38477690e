"""Paths along a finger: lengths, their gradients, and the sections that chambers leave."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from scipy.integrate import quad

from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import YIELDS, CreepBranch, PressureLaw
from soft_gripper.fingers.paths import Chamber, Tendon, length_gradients, path_lengths
from soft_gripper.fingers.pressure_drive import PressureDrive

SOLID = CrossSection(0.02, 0.02, 2.67e5, 1070.0)
LENGTH = 0.12


def finger(*paths, segments=12, section=SOLID, yields=YIELDS, **fields):
    chambers = tuple(path for path in paths if isinstance(path, Chamber))
    tendons = tuple(path for path in paths if isinstance(path, Tendon))
    return Finger("f", LENGTH, section, section, 0.017, segments, 0.02, yields=yields, chambers=chambers,
                  tendons=tendons, **fields)  # fmt: skip


def tendon(x, y, at=(0.0, 1.0), **fields):
    return Tendon("t", tuple(np.atleast_1d(x)), tuple(np.atleast_1d(y)), at, **fields)


def chamber(name, x, y, width=5e-3, thickness=5e-3, at=(0.0, 1.0)):
    return Chamber(name, (x,), (y,), at, (width,), (thickness,))


def equally(segments, **angles):
    """Joints that stand at equal angles, rad or m in all."""
    return {way: np.full(segments, angle / segments) for way, angle in angles.items()}


SLANTED = tendon([8e-3, -6e-3, 2e-3], [-7e-3, 0.0, 7e-3], (0.05, 0.4, 0.93))


def test_lengths_are_those_of_lines_in_space():
    """A rod of constant strains, whose centre line and section are known in closed form, and a slanted line on it."""
    turning = np.array([0.3, 0.9, 0.7])  # of the whole rod about x, y and z, rad: its section turns about one axis
    path = tendon([8e-3, -6e-3], [-7e-3, 5e-3])

    def speed(s):
        """Change of the line per length, in the turning section."""
        share = s / LENGTH
        x, y = 8e-3 - 14e-3 * share, -7e-3 + 12e-3 * share
        along = np.array([-14e-3, 12e-3, 0.0]) / LENGTH
        return np.linalg.norm(along + np.array([0, 0, 1.05]) + np.cross(turning / LENGTH, [x, y, 0]))

    expected = quad(speed, 0, LENGTH)[0]
    errors = []
    for segments in (10, 20):
        built = finger(path, segments=segments)
        q = equally(segments, sideways=0.3, bending=0.9, twist=0.7, stretch=0.05 * LENGTH)
        errors.append(path_lengths(built.tendon_paths, q)[0] - expected)
    assert abs(errors[1]) < 1e-6
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.05)  # of second order


@pytest.mark.parametrize("ways", [YIELDS, ("bending", "stretch")], ids=["in space", "in the plane"])
@pytest.mark.parametrize("path", [SLANTED, tendon(5e-3, 0.0, (0.0, 0.5)), tendon([8e-3, -6e-3], 0.0)])
def test_gradients_are_the_derivatives_of_lengths(path, ways):
    built, rng, step = finger(path), np.random.default_rng(1), 1e-6
    q = {way: 0.2 * rng.standard_normal(12) * (1e-2 if way == "stretch" else 1) for way in ways}
    found = {way: np.broadcast_to(each, (1, 12)) for way, each in length_gradients(built.tendon_paths, q).items()}
    for way in ways:
        for joint in range(12):
            moved = [q | {way: q[way] + sign * step * (np.arange(12) == joint)} for sign in (1, -1)]
            ahead, behind = (path_lengths(built.tendon_paths, each)[0] for each in moved)
            assert found[way][0, joint] == pytest.approx((ahead - behind) / (2 * step), abs=1e-8)


def test_a_path_that_ends_before_the_tip_leaves_the_rest_alone():
    built = finger(tendon(8e-3, 0.0, (0.0, 0.4)))
    gains = built.tension_gains["bending"][0] / 8e-3
    np.testing.assert_allclose(gains, [1, 1, 1, 1, 0.8, 0, 0, 0, 0, 0, 0, 0], atol=1e-12)


def test_chambers_weaken_the_section_where_they_are():
    """Against the sums over rectangles by hand, and a section of two cut in halves for the twist."""
    pair = [chamber("left", 0.0, 5e-3), chamber("right", 0.0, -5e-3)]
    section = finger(*pair).section(0.05)
    area, modulus = 25e-6, 2.67e5
    own = modulus * 5e-3**4 / 12
    assert section.bending_stiffness == pytest.approx(modulus * 0.02**4 / 12 - 2 * own, rel=1e-12)
    assert section.sideways_stiffness == pytest.approx(
        modulus * 0.02**4 / 12 - 2 * (own + modulus * area * 25e-6), rel=1e-12
    )
    assert section.stretch_stiffness == pytest.approx(modulus * (4e-4 - 2 * area), rel=1e-12)
    turned = finger(chamber("front", 5e-3, 0.0), chamber("back", -5e-3, 0.0)).section(0.05)
    assert section.twist_stiffness == pytest.approx(turned.twist_stiffness, rel=1e-3)  # the section is square
    ends = finger(chamber("left", 0.0, 5e-3, at=(0.0, 0.5)), chamber("right", 0.0, -5e-3, at=(0.0, 0.5)))
    assert ends.section(0.07).area == SOLID.area
    assert ends.section(0.05).area == section.area


@pytest.mark.parametrize(
    ("paths", "field"),
    [
        ([chamber("a", 9e-3, 0.0)], "chamber.x"),
        ([chamber("a", 9.1e-3, 0.0, width=5e-4, thickness=2e-3)], "chamber.x"),
        ([chamber("a", 0.0, 0.0, width=21e-3, thickness=5e-4)], "chamber.y"),
        ([chamber("a", 0.0, 9e-3), chamber("b", 0.0, -9e-3)], "chamber.y"),
        ([tendon(11e-3, 0.0)], "tendon.x"),
        ([tendon(0.0, [0.0, 0.02])], "tendon.y"),
        ([chamber("a", 0.0, 5e-3)], "chamber.y"),
        ([chamber("a", 0.0, 0.0), chamber("b", 2e-3, 0.0)], "chamber.x"),
        ([chamber("a", 4e-3, 0.0), chamber("a", -4e-3, 0.0)], "chamber.name"),
        ([tendon(0.0, 0.0, (0.5, 0.2))], "tendons[0].at"),
        ([tendon(0.0, 0.0, (0.5,))], "tendons[0].at"),
        ([tendon([0.0, 1e-3], 0.0, (0.0, 0.5, 1.0))], "tendons[0].x"),
    ],
)
def test_what_cannot_be_built_is_refused(paths, field):
    with refused(field):
        finger(*paths)


def test_a_section_has_its_own_chamber_or_listed_ones(shipped_finger):
    with refused("chamber"):
        replace(shipped_finger, chambers=(chamber("a", -5e-3, 0.0, 2e-3, 2e-3),))


def test_one_pressure_is_for_one_chamber():
    both = finger(chamber("left", 0.0, 5e-3), chamber("right", 0.0, -5e-3))
    with refused("chambers", 2):
        both.pressure_torque(1e4)
    creeps = (CreepBranch(0.1, 1.0),)
    with refused("creep", creeps):
        replace(both, creep=creeps, pressure_law=PressureLaw((0.0, 1e5), (0.0, 2e5)))


OWN = {"law_pressure": (-1e5, 0.0, 1e5), "law_effective": (-1e5, 0.0, 3e5)}


def test_a_chamber_may_have_a_pressure_law_of_its_own():
    """In the plant's drive and in what estimators take for the torque; others have that of the finger, if any."""
    inner, outer = replace(chamber("inner", 5e-3, 0.0), **OWN), chamber("outer", -5e-3, 0.0)
    pressures = np.array([[2e4, 5e4], [-3e4, 1e4]])
    plain = finger(inner, outer)
    np.testing.assert_allclose(plain.effective_pressure(pressures), [[6e4, 5e4], [-3e4, 1e4]])
    both = finger(inner, outer, pressure_law=PressureLaw((0.0, 1e5), (0.0, 2e5)))
    np.testing.assert_allclose(both.effective_pressure(pressures), [[6e4, 1e5], [-3e4, 2e4]])
    torque = plain.torque_of_drive("bending", pressures)
    gains = plain.pressure_gains["bending"]
    np.testing.assert_allclose(torque, plain.effective_pressure(pressures) @ gains)
    drive = PressureDrive({"f": gains.T}, -1e5, 1e5, laws={"f": plain.laws})
    context = drive.CreateDefaultContext()
    drive.GetInputPort("f.pressure_command").FixValue(context, pressures[0])
    np.testing.assert_allclose(drive.GetOutputPort("actuation").Eval(context), torque[0])


@pytest.mark.parametrize(
    ("law", "field"),
    [
        ({"law_pressure": (0.0, 1e5)}, "chambers[0].law_effective"),
        ({"law_pressure": (0.0, 1e5), "law_effective": (1e3, 2e5)}, "chambers[0].law_effective"),
    ],
)
def test_laws_that_are_none_are_refused(law, field):
    with refused(field):
        finger(replace(chamber("inner", 5e-3, 0.0), **law))


def test_a_chamber_with_a_law_does_not_creep():
    with refused("creep"):
        finger(replace(chamber("inner", 5e-3, 0.0), **OWN), creep=(CreepBranch(0.1, 1.0),))
