"""CrossSection against integrals over a fine grid of what it is made of, closed forms, and misfits that are refused."""

from dataclasses import astuple, replace
from typing import NamedTuple

import numpy as np
import pytest

from soft_gripper.errors import InputError
from soft_gripper.fingers.cross_section import CrossSection, Hole, PiercedSection

SOLID = CrossSection(width=0.022, thickness=0.018, youngs_modulus=3e5, density=1050.0)
CHAMBER = replace(SOLID, chamber_width=9e-3, chamber_thickness=6e-3, chamber_center=-2e-3)
LAYER = replace(SOLID, layer_thickness=4e-4, layer_modulus=2e7)
ALL = replace(CHAMBER, layer_thickness=4e-4, layer_modulus=2e7)
BORES = PiercedSection(0.022, 0.018, 3e5, 1050.0, bores=tuple(Hole(4e-3, 5e-3, 2e-3, y) for y in (-6e-3, 6e-3)))
SECTIONS = {"solid": SOLID, "chamber": CHAMBER, "layer": LAYER, "all": ALL}
EVERY = pytest.mark.parametrize("section", SECTIONS.values(), ids=SECTIONS.keys())
PIERCED = pytest.mark.parametrize("section", [*SECTIONS.values(), BORES], ids=[*SECTIONS, "two bores"])
CELL = 2e-5  # m, side of the squares of the grid; all boundaries of the sections above lie between squares

QUANTITIES = ("chamber_area", "area", "neutral_axis", "bending_stiffness", "chamber_eccentricity")
QUANTITIES += ("inner_face", "outer_face", "mass_center", "gyration", "layer_center")


class Grid(NamedTuple):
    """Squares of a section, seen from the middle of its outline."""

    x: np.ndarray  # m, (X, 1)
    y: np.ndarray  # m, (1, Y)
    modulus: np.ndarray  # Pa, (X, Y)
    density: np.ndarray  # kg/m^3, (X, Y)
    chamber: np.ndarray  # whether it is air, (X, Y)
    layer: np.ndarray  # whether it is the strain-limiting layer, (X, Y)


def grid(section):
    def middles(size):
        count = round(size / CELL)
        return (np.arange(count) + 0.5 - count / 2) * CELL

    x, y = middles(section.thickness)[:, None], middles(section.width)[None, :]
    bores = [(np.abs(x - h.x) < h.thickness / 2) & (np.abs(y - h.y) < h.width / 2) for h in section.holes]
    chamber = np.any(bores, axis=0)
    layer = (section.thickness / 2 - x < section.layer_thickness) & (y == y)
    modulus = np.where(layer, section.layer_modulus, np.where(chamber, 0.0, section.youngs_modulus))
    return Grid(x, y, modulus, np.where(chamber, 0.0, section.density), chamber, layer)


def integral(values):
    return float(np.sum(values)) * CELL**2


@PIERCED
def test_bending_leaves_no_normal_force_and_its_moment_is_the_stiffness(section):
    """Of stresses E (x - x_n) per curvature."""
    cells = grid(section)
    stress = cells.modulus * (cells.x - section.neutral_axis)
    moment = integral(stress * (cells.x - section.neutral_axis))
    assert integral(stress) == pytest.approx(0, abs=1e-12 * integral(cells.modulus))
    assert section.bending_stiffness == pytest.approx(moment, rel=1e-5)


@PIERCED
def test_stiffness_sideways_and_against_stretch(section):
    cells = grid(section)
    assert section.stretch_stiffness == pytest.approx(integral(cells.modulus), rel=1e-9)
    assert section.sideways_stiffness == pytest.approx(integral(cells.modulus * cells.y**2), rel=1e-5)


def test_the_shear_modulus_of_a_layer_is_a_third_of_its_youngs_modulus_unless_it_is_given():
    isotropic, given = (replace(ALL, layer_shear_modulus=modulus).twist_stiffness for modulus in (0.0, 2e7 / 3))
    assert isotropic == given
    cloth = replace(ALL, layer_shear_modulus=ALL.youngs_modulus / 3)
    assert cloth.twist_stiffness == pytest.approx(CHAMBER.twist_stiffness, rel=1e-3)
    assert cloth.twist_stiffness < 0.9 * isotropic
    assert cloth.bending_stiffness == ALL.bending_stiffness


def test_twist_stiffness_along_a_finger_is_that_of_each_section(tapered_finger):
    along = tapered_finger.joint_arc_lengths
    each = [tapered_finger.section(s).twist_stiffness for s in along]
    np.testing.assert_allclose(tapered_finger.section(along).twist_stiffness, each, rtol=1e-6)


@EVERY
def test_pressure_has_the_moment_of_its_area_about_the_neutral_axis(section):
    cells = grid(section)
    moment = integral(cells.chamber * (section.neutral_axis - cells.x))
    assert section.chamber_area == pytest.approx(integral(cells.chamber), rel=1e-9)
    assert section.chamber_area * section.chamber_eccentricity == pytest.approx(moment, rel=1e-9)


@PIERCED
def test_mass_and_its_centre_and_radii_of_gyration(section):
    cells = grid(section)
    mass = integral(cells.density)
    center = integral(cells.density * cells.x) / mass
    along_x, along_y = (integral(cells.density * d**2) / mass for d in (cells.x - center, cells.y))
    assert section.density * section.area == pytest.approx(mass, rel=1e-9)
    assert section.mass_center == pytest.approx(center - section.neutral_axis, abs=1e-12)
    assert section.gyration == pytest.approx((along_x, along_y), rel=1e-5)


@EVERY
def test_faces_and_layer(section):
    cells = grid(section)
    faces = cells.x[-1, 0] + CELL / 2, cells.x[0, 0] - CELL / 2
    found = section.inner_face + section.neutral_axis, section.outer_face + section.neutral_axis
    assert found == pytest.approx(faces, abs=1e-12)
    if section.layer_thickness:
        assert section.layer_center == pytest.approx(cells.x[cells.layer[:, 0]].mean(), abs=1e-12)


@pytest.mark.parametrize("section", [CHAMBER, ALL], ids=["chamber", "all"])
def test_walls_are_of_silicone(section):
    """Counted on the lines through the middle of the chamber."""
    cells = grid(section)
    x, y = np.nonzero(cells.chamber)
    across, silicone = cells.chamber.shape[1], ~cells.chamber & ~cells.layer
    counts = {
        "side": silicone[x.min(), : y.min()].sum(),
        "outer": silicone[: x.min(), across // 2].sum(),
        "inner": silicone[x.max() :, across // 2].sum(),
    }
    assert section.walls == pytest.approx({name: CELL * count for name, count in counts.items()}, abs=1e-12)


def test_sections_at_several_places_are_those_at_each():
    sections = [SOLID, CHAMBER, LAYER, ALL]
    together = CrossSection(*np.array([astuple(section) for section in sections]).T)
    for name in QUANTITIES:
        alone = np.array([getattr(section, name) for section in sections]).T
        np.testing.assert_allclose(getattr(together, name), alone, rtol=1e-14, atol=1e-18)
    for name, wall in together.walls.items():
        np.testing.assert_allclose(wall, [section.walls[name] for section in sections], rtol=1e-14)


# What is changed in the base of the shipped finger, 20 mm by 20 mm with a chamber of 9 mm by 10 mm, 1 mm off the
# middle, and a layer of 0.2 mm; which field and value are named, and what is said to be right.
HALF_CHAMBER = "a chamber has a width and a thickness, a solid section neither"
HALF_LAYER = "a layer has a thickness and a modulus"
NO_ROOM = "the chamber does not fit; it leaves walls of "
MISFITS = [
    ({"chamber_width": 0.021}, "chamber_width", 0.021, NO_ROOM + "side -0.50 mm, outer 4.00 mm, inner 5.80 mm"),
    ({"chamber_center": -0.006}, "chamber_center", -0.006, NO_ROOM + "side 5.50 mm, outer -1.00 mm, inner 10.80 mm"),
    ({"chamber_center": 0.0049}, "chamber_center", 0.0049, NO_ROOM + "side 5.50 mm, outer 9.90 mm, inner -0.10 mm"),
    ({"layer_thickness": 0.007}, "chamber_center", -0.001, NO_ROOM + "side 5.50 mm, outer 4.00 mm, inner -1.00 mm"),
    ({"chamber_width": 0.0}, "chamber_width", 0.0, HALF_CHAMBER),
    ({"chamber_thickness": 0.0}, "chamber_width", 0.009, HALF_CHAMBER),
    ({"layer_thickness": 0.0}, "layer_modulus", 1e9, HALF_LAYER),
    ({"layer_modulus": 0.0}, "layer_modulus", 0.0, HALF_LAYER),
    (
        {"layer_thickness": 0.0, "layer_modulus": 0.0, "layer_shear_modulus": 1e7},
        *("layer_shear_modulus", 1e7, "leave it out: there is no layer"),
    ),
    ({"layer_thickness": 0.02}, "layer_thickness", 0.02, "give less than the thickness, 0.02 m"),
    # Of silicone alone, less the chamber: x_n = -90 mm^2 * 3.1 mm / (400 - 90) mm^2 = -0.9 mm.
    (
        {"chamber_center": 0.0031, "layer_thickness": 0.0, "layer_modulus": 0.0},
        *("chamber_center", 0.0031, "pressure would open the finger: give less than the neutral axis, -0.0009 m"),
    ),
]


@pytest.mark.parametrize(("changes", "field", "value", "expected"), MISFITS)
def test_what_cannot_be_moulded_is_refused(shipped_finger, changes, field, value, expected):
    with pytest.raises(InputError) as caught:
        replace(shipped_finger, tip=replace(shipped_finger.base, **changes))
    assert str(caught.value) == f"finger 'finger': tip.{field} = {value!r}: {expected}"


def test_less_than_the_neutral_axis_will_do(shipped_finger):
    homogeneous = replace(shipped_finger.base, layer_thickness=0.0, layer_modulus=0.0, chamber_center=-0.00091)
    finger = replace(shipped_finger, base=homogeneous, tip=homogeneous)
    assert (finger.pressure_gain > 0).all()
