"""<finger> elements: what may be left out, and one line for every mistake."""

import xml.etree.ElementTree as ET
from copy import deepcopy
from dataclasses import replace

import pytest
from refusals import refused, refused_finger

from soft_gripper.fingers.cross_section import CrossSection, Station
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import read_finger_element
from soft_gripper.fingers.finger_parts import ContactMaterial, CreepBranch, ElasticLaw, PressureLaw, TipLoad
from soft_gripper.fingers.paths import Chamber, Tendon

OF_SILICONE = 'youngs_modulus="8e5" density="1100"'
CHAMBER = 'chamber_width="9e-3" chamber_thickness="8e-3" chamber_center="-1e-3"'
LAYER = 'layer_thickness="2e-4" layer_modulus="1e9"'
SECTION = f"{OF_SILICONE} {CHAMBER} {LAYER}"
ENDS = """
  <parent link="palm"/>
  <origin xyz="0.1 -0.2 0.3" rpy="0 0 3.14"/>
  <base width="0.03" thickness="0.02" {0}/>
  <tip width="0.025" thickness="0.015" {0}/>
  <sensors spacing="0.014"/>"""
PLANAR = f"""<finger name="left">{ENDS.format(SECTION)}
  <body length="0.12" segments="6" relaxation_time="0.02" shear_factor="0.857" yields=" bending "/>
  <section at="0.4" width="0.028" thickness="0.018" {SECTION}/>
  <contact friction="0.7" hydroelastic_modulus="1e5" dissipation="2"/>
  <elastic_law angle="-0.2 0 0.4" base_torque="-0.4 0 0.5" tip_torque="-0.3 0 0.25"/>
  <creep share="0.02 0.01" time="0.3 4"/>
  <pressure_law pressure="0 1e5" effective="0 1.1e5"/>
  <tip_load mass="0.05" xyz="0.015 0 -0.002"/>
</finger>"""
IN_SPACE = f"""<finger name="left">{ENDS.format(OF_SILICONE)}
  <body length="0.12" yields="bending  sideways twist"/>
  <chamber name="a" x="5e-3" y="0" width="4e-3" thickness="4e-3" law_pressure="0 1e5" law_effective="0 2e5"/>
  <chamber name="b" x="-5e-3" y="0 0" at="0 0.9" width="4e-3" thickness="4e-3"/>
  <tendon name="t" x="5e-3 -2e-3" y="0 6e-3" at="0 0.9" stiffness="2e3" friction="0.2" slack="1e-4"/>
</finger>"""
FINGERS = {"planar": PLANAR, "in space": IN_SPACE}
REQUIRED = {
    "parent": ["link"],
    "body": ["length"],
    "base": ["width", "thickness", "youngs_modulus", "density"],
    "tip": ["width", "thickness", "youngs_modulus", "density"],
    "sensors": ["spacing"],
    "section": ["at"],
    "creep": ["share", "time"],
    "pressure_law": ["pressure", "effective"],
    "elastic_law": ["angle", "base_torque", "tip_torque"],
    "tip_load": ["mass"],
}
ELEMENTS = ("parent", "body", "base", "tip", "sensors")  # which every finger has
PLACES = [
    (kind, number, attribute)
    for kind, text in FINGERS.items()
    for number, child in enumerate(ET.fromstring(text))
    for attribute in child.attrib
]


def read(text, segments=None):
    return read_finger_element("gripper.urdf", ET.fromstring(text), segments).finger


def place_of(child):
    """What a message calls an element; sections are numbered."""
    return "section[0]" if child.tag == "section" else child.tag


def test_a_complete_element_is_a_finger():
    section = (8e5, 1100.0, 9e-3, 8e-3, -1e-3, 2e-4, 1e9)
    base, tip = CrossSection(0.03, 0.02, *section), CrossSection(0.025, 0.015, *section)
    expected = Finger(
        *("left", 0.12, base, tip, 0.014, 6, 0.02, ContactMaterial(0.7, 1e5, 2.0)),
        sections=(Station(0.028, 0.018, *section, at=0.4),),
        shear_factor=0.857,
        elastic_law=ElasticLaw((-10.0, 0.0, 20.0), (-0.4, 0.0, 0.5), (-0.3, 0.0, 0.25)),
        creep=(CreepBranch(0.02, 0.3), CreepBranch(0.01, 4.0)),
        pressure_law=PressureLaw((0.0, 1e5), (0.0, 1.1e5)),
        tip_load=TipLoad(0.05, 0.015, -0.002),
    )
    mounted = read_finger_element("gripper.urdf", ET.fromstring(PLANAR))
    assert mounted.finger == expected
    assert (mounted.parent, mounted.xyz, mounted.rpy) == ("palm", (0.1, -0.2, 0.3), (0.0, 0.0, 3.14))


def test_a_complete_element_in_space_is_a_finger():
    solid = [CrossSection(*size, 8e5, 1100.0) for size in ((0.03, 0.02), (0.025, 0.015))]
    law = {"law_pressure": (0.0, 1e5), "law_effective": (0.0, 2e5)}
    chambers = (
        Chamber("a", (5e-3,), (0.0,), (0.0, 1.0), (4e-3,), (4e-3,), **law),
        Chamber("b", (-5e-3,), (0.0, 0.0), (0.0, 0.9), (4e-3,), (4e-3,)),
    )
    tendon = Tendon("t", (5e-3, -2e-3), (0.0, 6e-3), (0.0, 0.9), 2e3, 0.2, slack=1e-4)
    found, ways = read(IN_SPACE), ("bending", "sideways", "twist")
    assert found == Finger("left", 0.12, *solid, 0.014, yields=ways, chambers=chambers, tendons=(tendon,))


def test_what_may_be_left_out_has_defaults():
    for text in FINGERS.values():
        element = ET.fromstring(text)
        for child in list(element):
            child.attrib = {name: child.attrib[name] for name in REQUIRED.get(child.tag, [])}
            if child.tag not in ELEMENTS:
                element.remove(child)
        mounted = read_finger_element("gripper.urdf", element)
        solid = [CrossSection(*size, 8e5, 1100.0) for size in ((0.03, 0.02), (0.025, 0.015))]
        assert mounted.finger == Finger("left", 0.12, *solid, 0.014, segments=12, relaxation_time=0.015)
        assert (mounted.xyz, mounted.rpy) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def test_segments_take_the_place_of_the_files():
    """The elastic law stays that of the segments in the file."""
    assert read(PLANAR, 3).segments == 3
    assert read(PLANAR, 3).elastic_law == read(PLANAR).elastic_law
    with refused("body.segments", 0):
        read(PLANAR, segments=0)


def test_a_material_stands_for_modulus_and_density():
    found, complete = read(PLANAR.replace(OF_SILICONE, 'material="elastosil_m4601"', 1)), read(PLANAR)
    assert found == replace(complete, base=replace(complete.base, youngs_modulus=0.66e6, density=1130.0))


@pytest.mark.parametrize(("kind", "number", "attribute"), PLACES)
def test_an_attribute_that_is_no_number_is_refused(kind, number, attribute):
    """Words, numbers with a unit, and what is not finite."""
    for value in ("soft", "0.1m", "nan") if attribute not in ("link", "name") else ():
        element = ET.fromstring(FINGERS[kind])
        child = element[number]
        child.set(attribute, value)
        is_path = child.tag in ("chamber", "tendon")
        field, part = (
            (attribute, f"{child.tag} '{child.get('name')}'") if is_path else (f"{place_of(child)}.{attribute}", "")
        )
        refused_finger(element, field, value, part)


@pytest.mark.parametrize(("kind", "number", "attribute"), PLACES)
def test_an_attribute_that_is_misspelt_or_missing_is_named(kind, number, attribute):
    element = ET.fromstring(FINGERS[kind])
    child = element[number]
    value = child.attrib.pop(attribute)
    if attribute in REQUIRED.get(child.tag, []):
        refused_finger(element, f"{place_of(child)}.{attribute}", None)
    child.set(f"{attribute}x", value)
    refused_finger(element, "attribute", f"{attribute}x", f"<{child.tag}>")


@pytest.mark.parametrize("kind", FINGERS)
def test_an_element_that_is_misspelt_missing_or_there_twice_is_named(kind):
    for number, child in enumerate(ET.fromstring(FINGERS[kind])):
        element = ET.fromstring(FINGERS[kind])
        element[number].tag += "s"
        refused_finger(element, "element", f"{child.tag}s")
        twice = ET.fromstring(FINGERS[kind])
        twice.append(deepcopy(twice[number]))
        if child.tag not in ("section", "chamber", "tendon"):
            refused_finger(twice, "element", child.tag)
        element.remove(element[number])
        if child.tag in ELEMENTS:
            refused_finger(element, child.tag, None)


@pytest.mark.parametrize(
    ("old", "new", "field", "value"),
    [
        ('"6"', '"6.5"', "body.segments", "6.5"),
        (" bending ", "twist", "body.yields", "twist"),
        ("0.1 -0.2 0.3", "0.1 -0.2", "origin.xyz", "0.1 -0.2"),
        ('"0.3 4"', '"0.3"', "creep.time", (0.3,)),
        ('"0.02 0.01"', '"0.2 0.9"', "creep.share", [0.2, 0.9]),
        ("0.015 0 -0.002", "0.015 0.01 -0.002", "tip_load.xyz", (0.015, 0.01, -0.002)),
        ("-0.3 0 0.25", "-0.3 0", "elastic_law.tip_torque", (-0.3, 0.0)),
        ("-0.4 0 0.5", "0.4 0 0.5", "elastic_law.base_torque", (0.4, 0.0, 0.5)),
        ('at="0.4"', 'at="1.4"', "section[0].at", 1.4),
        (OF_SILICONE, 'material="rubber"', "base.material", "rubber"),
        (OF_SILICONE, 'material="ecoflex_00_30" youngs_modulus="1"', "base.youngs_modulus", "1"),
        ('name="left"', 'name="left" segments="6"', "attribute", "segments"),
    ],
)
def test_what_does_not_fit_is_named(old, new, field, value):
    assert old in PLANAR
    refused_finger(ET.fromstring(PLANAR.replace(old, new, 1)), field, value)


@pytest.mark.parametrize("name", ['name=""', ""])
def test_a_finger_has_a_name(name):
    with refused("finger.name", None if not name else ""):
        read(PLANAR.replace('name="left"', name, 1))
