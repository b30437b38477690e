"""<finger> elements: what may be left out, and one line for every mistake."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import read_finger_element
from soft_gripper.fingers.finger_parts import ContactMaterial, CreepBranch, ElasticLaw, PressureLaw, TipLoad

CHAMBER = 'chamber_width="9e-3" chamber_thickness="8e-3" chamber_center="-1e-3"'
LAYER = 'layer_thickness="2e-4" layer_modulus="1e9"'
SECTION = f'youngs_modulus="8e5" density="1100" {CHAMBER} {LAYER}'
COMPLETE = f"""
<finger name="left">
  <parent link="palm"/>
  <origin xyz="0.1 -0.2 0.3" rpy="0 0 3.14"/>
  <body length="0.12" segments="6" relaxation_time="0.02"/>
  <base width="0.03" thickness="0.02" {SECTION}/>
  <tip width="0.025" thickness="0.015" {SECTION}/>
  <sensors spacing="0.014"/>
  <contact friction="0.7" hydroelastic_modulus="1e5" dissipation="2"/>
</finger>"""
LAW = '<elastic_law angle="-0.2 0 0.4" base_torque="-0.4 0 0.5" tip_torque="-0.3 0 0.25"/>'
REAL = """
  <creep share="0.2 0.1" time="0.3 4"/>
  <pressure_law pressure="0 1e5" effective="0 1.1e5"/>
  <tip_load mass="0.05" xyz="0.015 0 -0.002"/>"""
REQUIRED = {
    "parent": ["link"],
    "body": ["length"],
    "base": ["width", "thickness", "youngs_modulus", "density"],
    "tip": ["width", "thickness", "youngs_modulus", "density"],
    "sensors": ["spacing"],
}


def read(text, segments=None):
    return read_finger_element("gripper.urdf", ET.fromstring(text), segments)


def edited(old, new):
    assert old in COMPLETE
    return COMPLETE.replace(old, new, 1)


def complaint(element):
    """The message about a wrong element: one line that names the file."""
    with pytest.raises(InputError) as caught:
        read_finger_element("gripper.urdf", element)
    message = str(caught.value)
    assert message.startswith("gripper.urdf: ")
    assert "\n" not in message
    return message.removeprefix("gripper.urdf: ")


def test_complete_element():
    mounted = read(COMPLETE)
    rest = (8e5, 1100.0, 9e-3, 8e-3, -1e-3, 2e-4, 1e9)
    base, tip = CrossSection(0.03, 0.02, *rest), CrossSection(0.025, 0.015, *rest)
    contact = ContactMaterial(0.7, 1e5, 2.0)
    assert mounted.finger == Finger("left", 0.12, base, tip, 0.014, 6, 0.02, contact)
    assert (mounted.parent, mounted.xyz, mounted.rpy) == ("palm", (0.1, -0.2, 0.3), (0.0, 0.0, 3.14))


def test_what_may_be_left_out_has_defaults():
    element = ET.fromstring(edited(' segments="6" relaxation_time="0.02"', ""))
    for tag in ("origin", "contact"):
        element.remove(element.find(tag))
    mounted = read_finger_element("gripper.urdf", element)
    assert (mounted.xyz, mounted.rpy) == ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert (mounted.finger.segments, mounted.finger.relaxation_time) == (12, 0.015)
    assert mounted.finger.contact == ContactMaterial()


@pytest.mark.parametrize("without", [CHAMBER, LAYER])
def test_a_chamber_and_a_layer_may_be_left_out(without):
    names = [part.split("=")[0] for part in without.split()]
    finger, complete = read(COMPLETE.replace(without, "")).finger, read(COMPLETE).finger
    for found, whole in ((finger.base, complete.base), (finger.tip, complete.tip)):
        assert found == replace(whole, **dict.fromkeys(names, 0.0))


def test_parts_of_the_optional_elements_may_be_left_out():
    mounted = read(edited('xyz="0.1 -0.2 0.3" ', "").replace(' hydroelastic_modulus="1e5" dissipation="2"', ""))
    assert (mounted.xyz, mounted.rpy) == ((0.0, 0.0, 0.0), (0.0, 0.0, 3.14))
    assert mounted.finger.contact == ContactMaterial(friction=0.7)


def test_segments_take_the_place_of_the_files():
    assert read(COMPLETE, segments=3).finger.segments == 3
    with refused("body.segments", 0):
        read(COMPLETE, segments=0)


@pytest.mark.parametrize("segments", [None, 3, 24])
def test_elastic_law_is_that_of_the_segments_in_the_file(segments):
    law = read(edited("<sensors", f"{LAW}<sensors"), segments).finger.elastic_law
    assert law == ElasticLaw((-10.0, 0.0, 20.0), (-0.4, 0.0, 0.5), (-0.3, 0.0, 0.25))


def test_what_makes_a_finger_real():
    finger = read(edited('time="0.02"/>', 'time="0.02" shear_factor="0.857"/>').replace("<sensors", f"{REAL}<sensors"))
    expected = replace(
        read(COMPLETE).finger,
        creep=(CreepBranch(0.2, 0.3), CreepBranch(0.1, 4.0)),
        pressure_law=PressureLaw((0.0, 1e5), (0.0, 1.1e5)),
        shear_factor=0.857,
        tip_load=TipLoad(0.05, 0.015, -0.002),
    )
    assert finger.finger == expected


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"0.3 4"', '"0.3"', "creep.time = (0.3,)"),
        ('"0.3 4"', '"0.3 soon"', "creep.time = '0.3 soon'"),
        ('"0.2 0.1"', '"0.2 0.9"', "creep.share = [0.2, 0.9]"),
        (' effective="0 1.1e5"', "", "pressure_law.effective = None: the attribute is missing"),
        (' mass="0.05"', "", "tip_load.mass = None: the attribute is missing"),
        ('"0.05"', '"-0.05"', "tip_load.mass = -0.05"),
        ("0.015 0 -0.002", "0.015 0.01 -0.002", "tip_load.xyz = (0.015, 0.01, -0.002): the finger bends in a plane"),
    ],
)
def test_mistakes_in_what_makes_a_finger_real(old, new, message):
    text = edited("<sensors", f"{REAL}<sensors")
    assert old in text
    assert complaint(ET.fromstring(text.replace(old, new))).startswith(f"finger 'left': {message}")


OF_SILICONE = 'youngs_modulus="8e5" density="1100"'


def test_a_material_stands_for_modulus_and_density():
    finger = read(edited(OF_SILICONE, 'material="elastosil_m4601"')).finger
    complete = read(COMPLETE).finger
    assert finger == replace(complete, base=replace(complete.base, youngs_modulus=0.66e6, density=1130.0))


@pytest.mark.parametrize(
    ("new", "message"),
    [
        (
            'material="rubber"',
            "base.material = 'rubber': not known; known: ecoflex_00_30, ecoflex_00_50, dragon_skin_10,",
        ),
        ('material="ecoflex_00_30" density="1"', "base.density = '1': the material gives it; leave one out"),
        ('material="ecoflex_00_30" youngs_modulus="1"', "base.youngs_modulus = '1': the material gives it"),
    ],
)
def test_mistakes_in_a_material(new, message):
    assert complaint(ET.fromstring(edited(OF_SILICONE, new))).startswith(f"finger 'left': {message}")


def test_ways_to_yield_are_of_the_body():
    assert read(COMPLETE).finger.yields == ("bending",)
    found = read(edited('time="0.02"/>', 'time="0.02" yields=" bending  twist "/>')).finger
    assert found.yields == ("bending", "twist")


@pytest.mark.parametrize("ways", ["bending sideways", "bending, twist", "", "twist"])
def test_ways_to_yield_that_are_wrong_name_the_field(ways):
    with pytest.raises(InputError) as caught:
        read(edited('time="0.02"/>', f'time="0.02" yields="{ways}"/>'))
    assert caught.value.field == "body.yields"


def test_a_shear_factor_is_of_the_body():
    text = edited('time="0.02"/>', 'time="0.02" shear_factor="-1"/>')
    assert complaint(ET.fromstring(text)).startswith("finger 'left': body.shear_factor = -1.0")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (' base_torque="-0.4 0 0.5"', "", "elastic_law.base_torque = None: the attribute is missing"),
        ("-0.2 0 0.4", "-0.2, 0, 0.4", "elastic_law.angle = '-0.2, 0, 0.4'"),
        ("-0.3 0 0.25", "-0.3 0", "elastic_law.tip_torque = (-0.3, 0.0)"),
        ('"0.12"', '"0"', "body.length = 0.0"),
    ],
)
def test_mistakes_in_an_elastic_law_are_named(old, new, message):
    text = edited("<sensors", f"{LAW}<sensors")
    assert old in text
    element = ET.fromstring(text.replace(old, new, 1))
    assert complaint(element).startswith(f"finger 'left': {message}")


@pytest.mark.parametrize("tag", REQUIRED)
def test_missing_element(tag):
    element = ET.fromstring(COMPLETE)
    element.remove(element.find(tag))
    assert complaint(element) == f"finger 'left': {tag} = None: the element <{tag}> is missing"


@pytest.mark.parametrize(("tag", "attribute"), [(t, a) for t, names in REQUIRED.items() for a in names])
def test_missing_attribute(tag, attribute):
    element = ET.fromstring(COMPLETE)
    del element.find(tag).attrib[attribute]
    assert complaint(element) == f"finger 'left': {tag}.{attribute} = None: the attribute is missing"


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("<sensors", "<sensor", "finger 'left': element = 'sensor': not known here; did you mean 'sensors'?"),
        ("<sensors", "<x/><sensors", "finger 'left': element = 'x': not known here; known: parent, "),
        ("width", "widht", "finger 'left': <base>: attribute = 'widht': not known here; did you mean 'wid"),
        ("spacing", "x", "finger 'left': <sensors>: attribute = 'x': not known here; known: spacing"),
        ("friction", "frction", "finger 'left': <contact>: attribute = 'frction': not known here; did"),
        (
            "<sensors",
            "<sensors spacing='1'/><sensors",
            "finger 'left': element = 'sensors': appears more than",
        ),
        ('"0.12"', '"0.12m"', "finger 'left': body.length = '0.12m'"),
        ('"0.12"', '""', "finger 'left': body.length = ''"),
        ('"6"', '"6.5"', "finger 'left': body.segments = '6.5'"),
        ('"1e5"', '"soft"', "finger 'left': contact.hydroelastic_modulus = 'soft'"),
        ("0.1 -0.2 0.3", "0.1 -0.2", "finger 'left': origin.xyz = '0.1 -0.2'"),
        ("0 0 3.14", "0 0 pi", "finger 'left': origin.rpy = '0 0 pi'"),
        ("0 0 3.14", "0 0 nan", "finger 'left': origin.rpy = '0 0 nan'"),
        ('name="left"', 'name=""', "finger.name = ''"),
        ('name="left"', "", "finger.name = None"),
        ('name="left"', 'name="left" segments="6"', "finger 'left': attribute = 'segments': not known here"),
        ('"0.014"', '"-0.014"', "finger 'left': sensors.spacing = -0.014"),
        ('"0.015"', '"nan"', "finger 'left': tip.thickness = 'nan'"),
        ('"6"', '"0"', "finger 'left': body.segments = 0"),
    ],
)
def test_mistakes_are_named(old, new, message):
    assert complaint(ET.fromstring(edited(old, new))).startswith(message)
