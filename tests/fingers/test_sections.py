"""Fingers of several sections: piecewise linear, steps, parts without a chamber; and what cannot be built."""

import xml.etree.ElementTree as ET
from dataclasses import astuple, fields, replace
from pathlib import Path

import numpy as np
import pytest
from refusals import refusal, refused

from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.files.xml_text import DRAKE
from soft_gripper.fingers.cross_section import CrossSection, Station
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement, read_finger_element
from soft_gripper.fingers.finger_links import finger_to_urdf
from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.models import DIRECTORY
from soft_gripper.sensors.sensor_layout import SensorLayout

HINT = DRAKE + "mesh_resolution_hint"
NO_CHAMBER = {"chamber_width": 0.0, "chamber_thickness": 0.0, "chamber_center": 0.0}


def station(section: CrossSection, at: float, **changes: float) -> Station:
    """A cross-section at a place, with some other numbers."""
    numbers = dict(zip((part.name for part in fields(CrossSection)), astuple(section), strict=True))
    return Station(**(numbers | changes), at=at)


@pytest.fixture
def varied(tapered_finger: Finger) -> Finger:
    """Of many segments, with a chamber that ends in a taper, a step behind it, and a bulge."""
    base = tapered_finger.base
    between = (
        station(base, 0.2, thickness=0.022),
        station(base, 0.5, **NO_CHAMBER),
        station(base, 0.5, **NO_CHAMBER, youngs_modulus=1e5, width=0.015),
        station(base, 0.8, **NO_CHAMBER, thickness=0.012, layer_modulus=5e8),
    )
    return replace(tapered_finger, sections=between, tip=replace(tapered_finger.tip, **NO_CHAMBER), segments=20)


def number_at(finger: Finger, name: str, s: float) -> float:
    """Piecewise linear, by NumPy; not at a step."""
    values = [getattr(section, name) for section in finger.cross_sections]
    return float(np.interp(s / finger.length, finger.places, values))


def test_every_number_is_linear_from_one_section_to_the_next(varied: Finger) -> None:
    s = np.linspace(0, varied.length, 48)
    found = varied.section(s)
    for part in fields(CrossSection):
        expected = [number_at(varied, part.name, one) for one in s]
        np.testing.assert_allclose(getattr(found, part.name), expected, rtol=1e-12, atol=1e-18)
        assert [getattr(varied.section(one), part.name) for one in s] == getattr(found, part.name).tolist()


@pytest.mark.parametrize("segments", [5, 15, 55, 95])
def test_a_link_with_a_step_in_its_middle_is_of_the_section_beyond(shipped_finger: Finger, segments: int) -> None:
    """However the place of its middle is rounded."""
    finger, link = stepped(shipped_finger, 0.4, segments, density=500.0), 2 * segments // 5
    assert finger.link_masses[link] == pytest.approx(500 * finger.base.area * finger.segment_length, rel=1e-9)
    assert finger.link_masses[link - 1] == pytest.approx(1070 * finger.base.area * finger.segment_length, rel=1e-9)


def derived(finger: Finger) -> list[np.ndarray]:
    """All that a finger's numbers lead to."""
    links = finger.links
    return [
        *finger.stiffnesses.values(),
        *finger.pressure_gains.values(),
        *(links.mass, links.center, links.gyration),
        finger.mass_matrix(),
        np.array([*finger.sensor_offsets, finger.stable_time_step()]),
    ]


@pytest.mark.parametrize("name", ["shipped_finger", "tapered_finger"])
def test_sections_that_say_nothing_new_change_nothing(name: str, request: pytest.FixtureRequest) -> None:
    finger = replace(request.getfixturevalue(name), yields=YIELDS)
    between = tuple(station(finger.section(at * finger.length), at) for at in (0.25, 0.4, 0.4, 0.85))
    same = replace(finger, sections=between)
    for found, expected in zip(derived(same), derived(finger), strict=True):
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-18)


def stepped(finger: Finger, share: float, segments: int, **beyond: float) -> Finger:
    """Uniform up to a share of the length, and uniform beyond it."""
    base = finger.base
    tip = replace(base, **beyond)
    return replace(finger, sections=(station(base, share), station(tip, share)), tip=tip, segments=segments)


def deflection_of_a_stepped_cantilever(finger: Finger, share: float) -> float:
    """Of the tip under a unit force across it, m/N, by the moment-area theorem."""
    length, rest = finger.length, (1 - share) * finger.length
    near, far = float(finger.base.bending_stiffness), float(finger.tip.bending_stiffness)
    return (length**3 - rest**3) / (3 * near) + rest**3 / (3 * far)


def deflection(finger: Finger) -> float:
    """Of the chain, for a small force, m/N."""
    levers = finger.length - finger.joint_arc_lengths
    return float(levers @ (levers / finger.stiffness))


def test_a_stepped_cantilever_converges_with_the_square_where_a_segment_ends(shipped_finger: Finger) -> None:
    errors = []
    for segments in (5, 10, 20, 40):
        finger = stepped(shipped_finger, 0.4, segments, youngs_modulus=5e4, thickness=0.018)
        exact = deflection_of_a_stepped_cantilever(finger, 0.4)
        errors.append(abs(deflection(finger) / exact - 1))
    assert errors[-1] < 4e-4
    np.testing.assert_allclose(np.log2(np.divide(errors[:-1], errors[1:])), 2, atol=0.01)


def test_a_chamber_bends_its_part_of_the_finger_alone(shipped_finger: Finger) -> None:
    finger = stepped(shipped_finger, 0.4, 15, **NO_CHAMBER)
    bend = free_bending_angles(finger, np.array(1e5))
    base = finger.base
    curvature = 1e5 * base.chamber_area * base.chamber_eccentricity / base.bending_stiffness
    assert bend.sum() == pytest.approx(float(curvature) * 0.4 * finger.length, rel=1e-12)
    assert (bend[6:] == 0).all()
    stretching = replace(finger, yields=("bending", "stretch"))
    assert (stretching.pressure_gains["stretch"][0, 6:] == 0).all()


def test_sensor_paths_lie_in_the_thinnest_section(shipped_finger: Finger) -> None:
    end = replace(shipped_finger.base, layer_thickness=0.0, layer_modulus=0.0)
    thin = station(end, 0.8, **NO_CHAMBER, thickness=0.012)
    finger = replace(shipped_finger, base=end, sections=(thin,), tip=end, sensor_spacing=0.012)
    assert finger.sensor_offsets == (0.006, -0.006)  # its neutral axis is in the middle, that of the ends is not
    (hint,) = {hint.get("value") for link in finger_to_urdf(FingerElement(finger, "world")) for hint in link.iter(HINT)}
    assert hint == "0.006"
    with refused("sensor_spacing", 0.013) as caught:
        replace(finger, sensor_spacing=0.013)
    assert "0.5 mm outside the finger at 0.8 of its length" in caught.value.expected


def test_loads_are_usual_where_the_base_has_no_chamber(shipped_finger: Finger) -> None:
    """The prior on loads follows from the largest driving torque."""
    base = replace(shipped_finger.base, **NO_CHAMBER)
    finger = replace(shipped_finger, base=base, sections=(station(base, 0.5), station(shipped_finger.base, 0.5)))
    uniform = replace(shipped_finger, tip=shipped_finger.base)
    found, expected = (
        Mechanics(SensorLayout(each, 1), Uncertainty()).load_variances / each.pressure_gain.max() ** 2
        for each in (finger, uniform)
    )
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("places", "number", "value"),
    [
        ((0.5, 0.4), 1, 0.4),
        ((0.3, 0.3, 0.3), 2, 0.3),
        ((0.3, 0.3 + 1e-8), 1, 0.3 + 1e-8),
        ((0.0,), 0, 0.0),
        ((1.0,), 0, 1.0),
    ],
)
def test_places_that_are_wrong(shipped_finger: Finger, places: tuple[float, ...], number: int, value: float) -> None:
    with refused(f"sections[{number}].at", value):
        replace(shipped_finger, sections=tuple(station(shipped_finger.base, at) for at in places))


def test_a_layer_has_a_shear_modulus_in_every_section_that_has_a_layer(shipped_finger: Finger) -> None:
    ends = {end: replace(getattr(shipped_finger, end), layer_shear_modulus=1e7) for end in ("base", "tip")}
    cloth, film = (station(ends["base"], 0.5, layer_shear_modulus=G) for G in (2e7, 0.0))
    bare = station(ends["base"], 0.5, layer_shear_modulus=0.0, layer_modulus=0.0, layer_thickness=0.0)
    for fits in (cloth, bare):
        replace(shipped_finger, **ends, sections=(fits,), sensor_spacing=0.001)
    with refused("layer_shear_modulus", 1e7):
        replace(shipped_finger, **ends, sections=(film,))


FINGER = (DIRECTORY / "grippers/conforming.urdf").read_text()


@pytest.mark.parametrize(
    ("old", "new", "field"),
    [
        ('at="0.4"', 'at="0.5"', "section[1].at = 0.4: "),
        ("-0.98e-3", "-5.98e-3", "section[0].chamber_center = -0.00598: the chamber does not fit"),
        ("ecoflex_00_30", "jelly", "section[1].material = 'jelly': not known"),
    ],
)
def test_mistakes_in_a_section_are_one_line(
    old: str, new: str, field: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert old in FINGER
    Path("bad.urdf").write_text(FINGER.replace(old, new, 1))
    line = refusal("expand", "bad.urdf")
    assert "bad.urdf: finger 'left_finger': " in line
    assert field in line


def test_sections_are_read_in_the_order_of_the_file() -> None:
    element = ET.fromstring(FINGER).find("finger")
    assert element is not None
    finger = read_finger_element("conforming.urdf", element).finger
    assert finger.places == (0.0, 0.4, 0.4, 1.0)
    first, second = finger.sections
    assert (first.youngs_modulus, first.chamber_width, first.chamber_thickness) == (2.67e5, 9e-3, 9.8e-3)
    assert (second.chamber_area, second.density) == (0.0, 1070.0)
    assert second.youngs_modulus == finger.tip.youngs_modulus == pytest.approx(118e3, rel=0.01)
