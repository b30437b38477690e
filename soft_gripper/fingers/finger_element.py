"""The <finger> component of a URDF: reading it, with errors that name the file, the field and the value.

    <frame name="fingers: load with soft_gripper.add_fingers, or soft-gripper expand"/>
    <finger name="left_finger">
      <parent link="palm"/>
      <origin xyz="-0.05 0 0" rpy="0 0 0"/>
      <body length="0.12" segments="12" relaxation_time="0.0065" yields="bending sideways twist"/>
      <base width="0.02" thickness="0.02" youngs_modulus="2.67e5" density="1070"
            chamber_width="9e-3" chamber_thickness="10e-3" chamber_center="-1e-3"
            layer_thickness="2e-4" layer_modulus="1e9" layer_shear_modulus="1e7"/>
      <section at="0.4" .../>
      <tip  .../>
      <sensors spacing="0.017"/>
      <contact friction="0.9" hydroelastic_modulus="2e5" dissipation="3"/>
      <elastic_law angle="-0.3 0 0.1 0.3" base_torque="-0.4 0 0.1 0.4" tip_torque="-0.3 0 0.08 0.3"/>
      <creep share="0.2 0.1" time="0.3 4"/>
      <pressure_law pressure="-5e4 0 1e5 2e5" effective="-5e4 0 1.05e5 2.3e5"/>
      <tip_load mass="0.05" xyz="0.015 0 0"/>
      <chamber name="outer" x="-3e-3" y="0" width="9e-3" thickness="8e-3" at="0 0.4"/>
      <tendon name="inner" x="8e-3" y="0" at="0 0.9" stiffness="2e3" friction="0.1"/>
    </finger>

`base` and `tip` are cross-sections as they are built, see `cross_section`, as is every `section` between them, `at` a
share of the length. From one to the next every number changes linearly; two at one place are a step. `origin` places
frame B, which lies on the neutral axis. All elements from `contact` on, `section` and `origin` may be left out, as may
`segments`, `relaxation_time`, `yields`, the chamber and the strain-limiting layer; the rest may not. `finger_parts`
explains the elements; in addition:

- `material` of a cross-section, such as "dragon_skin_10", stands for `youngs_modulus` and `density`, see `SILICONES`.
- `yields` of `body` names the ways in which the finger yields: "bending" in its plane (if left out, this alone), and
  "sideways" out of it, "twist", "stretch". In the others it is rigid.
- `layer_shear_modulus` (none: the layer is isotropic) tells a cloth from a film: threads along and across the finger
  shear almost as silicone does. Twist alone depends on it.
- `shear_factor` of `body` (none: rigid in shear) is the shear correction factor of Timoshenko's beam, 0.857 for a
  rectangle of what is incompressible (G. R. Cowper, *The Shear Coefficient in Timoshenko's Beam Theory*, J. Appl.
  Mech. 33, 1966: 10 (1 + nu) / (12 + 11 nu)).
- An elastic law gives torque (N m) against the angle (rad) of one joint, for the number of segments in the file; it
  replaces Young's modulus, which then determines damping, creep and shear only.
- `stiffness_taken` of `pressure_law` (none: pressure takes nothing) is the share of the stiffness that each pressure
  takes, of a linear finger that one pressure bends in its plane.
- Each `chamber` has a pressure of its own, and each `tendon` a tension. x and y (from the middle of the section, as
  `chamber_center`), width and thickness are one number, or one for each station `at` (shares of the length, "0 1" if
  left out), linear between: see `paths`. Chambers replace those of `base` and `tip`. `law_pressure` and
  `law_effective` of a chamber are the points of a pressure law of its own, instead of that of the finger.
- A tip load is a point mass at `xyz` m in the frame {finger}_tip; y is 0.

`urdf` explains the <frame>.

Silicones of which soft fingers are commonly moulded, by their names in a <finger>.

Where the maker states only the stress at 100 % strain, Young's modulus is that of a neo-Hookean solid with that
stress: at stretch 2 the nominal stress is  E / 3 (2 - 1 / 2^2) . For Dragon Skin 10 (22 psi) that rule gives 260 kPa,
and bending of a cantilever 264 kPa. Batches differ by more than that: identify your own finger.
"""

import re
import xml.etree.ElementTree as ET
from dataclasses import MISSING, dataclass, fields
from itertools import islice
from typing import Any, NamedTuple, TypeVar

from soft_gripper.errors import InputError, suggestion
from soft_gripper.files.xml_text import finite_numbers, read_numbers
from soft_gripper.fingers.cross_section import CrossSection, Station
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import ContactMaterial, CreepBranch, ElasticLaw, PressureLaw, TipLoad
from soft_gripper.fingers.paths import Chamber, Tendon

_Section = TypeVar("_Section", bound=CrossSection)
_PASCALS_PER_PSI = 6894.757  # Pa
_ECOFLEX_SOURCE = "Smooth-On, Ecoflex Series, technical bulletin: modulus at 100 % strain"
_CANTILEVER_SOURCE = "Sim-to-Real for Differentiable Projective Dynamics on Soft Robots, 2021"
_CONNOLLY_SOURCE = "F. Connolly et al., Mechanical Programming of Soft Actuators by Varying Fiber Angle, 2015"
_POLYGERINOS_SOURCE = "P. Polygerinos et al., Towards a Soft Pneumatic Glove for Hand Rehabilitation, 2013"
_DRAGON_SKIN_SOURCE = "Smooth-On, Dragon Skin Series, technical bulletin"
_CHILD_ATTRIBUTES = {
    "parent": ["link"],
    "origin": ["xyz", "rpy"],
    "body": ["length", "segments", "relaxation_time", "shear_factor", "yields"],
    "base": [*(f.name for f in fields(CrossSection)), "material"],
    "section": [*(f.name for f in fields(Station)), "material"],
    "tip": [*(f.name for f in fields(CrossSection)), "material"],
    "sensors": ["spacing"],
    "contact": [f.name for f in fields(ContactMaterial)],
    "elastic_law": ["angle", "base_torque", "tip_torque"],
    "creep": [f.name for f in fields(CreepBranch)],
    "pressure_law": [f.name for f in fields(PressureLaw)],
    "tip_load": ["mass", "xyz"],
    "chamber": [f.name for f in fields(Chamber)],
    "tendon": [f.name for f in fields(Tendon)],
}
_PATH_CLASSES = {"chamber": Chamber, "tendon": Tendon}
# Names in the file of those fields of a Finger that have another name there.
_NAMES_IN_FILE = {name: f"body.{name}" for name in _CHILD_ATTRIBUTES["body"]} | {
    "sensor_spacing": "sensors.spacing",
    "elastic_law.curvature": "elastic_law.angle",
    "elastic_law.base_moment": "elastic_law.base_torque",
    "elastic_law.tip_moment": "elastic_law.tip_torque",
    "tip_load.x": "tip_load.xyz",
    "tip_load.z": "tip_load.xyz",
}
_OPTIONAL = ("stiffness_taken",)  # of a law
_REQUIRED_TAGS = ("parent", "body", "base", "tip", "sensors")
_REPEATABLE_TAGS = ("section", *_PATH_CLASSES)
_BODY_FIELDS = ("segments", "relaxation_time", "shear_factor")


class Silicone(NamedTuple):
    """Properties of a silicone for a cross-section, and their source."""

    youngs_modulus: float  # Pa, of small strains
    density: float  # kg/m^3
    source: str


def _from_stress_at_twice_the_length(psi: float) -> float:
    """Young's modulus, Pa, of a neo-Hookean solid with that nominal stress at 100 % strain."""
    return 3 * psi * _PASCALS_PER_PSI / (2 - 1 / 4)


SILICONES = {
    "ecoflex_00_30": Silicone(_from_stress_at_twice_the_length(10), 1070.0, f"{_ECOFLEX_SOURCE} 10 psi"),
    "ecoflex_00_50": Silicone(_from_stress_at_twice_the_length(12), 1070.0, f"{_ECOFLEX_SOURCE} 12 psi"),
    "dragon_skin_10": Silicone(2.64e5, 1070.0, f"{_CANTILEVER_SOURCE}: bending of a cantilever; {_DRAGON_SKIN_SOURCE}"),
    "dragon_skin_30": Silicone(
        _from_stress_at_twice_the_length(86), 1080.0, f"{_DRAGON_SKIN_SOURCE}: modulus at 100 % strain 86 psi"
    ),
    "smooth_sil_950": Silicone(
        3 * 0.68e6, 1240.0, f"{_CONNOLLY_SOURCE}: neo-Hookean shear modulus 0.68 MPa; Smooth-On, Smooth-Sil Series"
    ),
    "elastosil_m4601": Silicone(
        6 * 0.11e6, 1130.0, f"{_POLYGERINOS_SOURCE}: Yeoh C1 = 0.11 MPa, E = 6 C1; Wacker, Elastosil M 4601, data sheet"
    ),
}


@dataclass(frozen=True)
class FingerElement:
    """A finger and its mount: the pose of frame B in the frame of the parent link."""

    finger: Finger
    parent: str
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)  # m
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)  # rad


class _Reader:
    """Reads the attributes of one <finger>; every error names the place."""

    def __init__(self, file: str, element: ET.Element):
        name = element.get("name")
        if not name:
            raise InputError(file, "finger.name", name, "give every <finger> a name")
        self.name, self.where, self.element = name, f"{file}: finger '{name}'", element
        _check_names(self.where, "attribute", list(element.keys()), ["name"])
        children = [child for child in element if isinstance(child.tag, str)]  # comments have none
        _check_names(self.where, "element", [child.tag for child in children], list(_CHILD_ATTRIBUTES))
        for tag in _REQUIRED_TAGS:
            if element.find(tag) is None:
                raise InputError(self.where, tag, None, f"the element <{tag}> is missing")
        for child in children:
            _check_names(f"{self.where}: <{child.tag}>", "attribute", list(child.keys()), _CHILD_ATTRIBUTES[child.tag])

    def child(self, tag: str) -> ET.Element | None:
        """The element <tag>; with "tag[i]" one of several."""
        name, _, number = tag.rstrip("]").partition("[")
        return next(islice(self.element.iterfind(name), int(number or 0), None), None)

    def text(self, tag: str, attribute: str) -> str:
        child = self.child(tag)
        value = None if child is None else child.get(attribute)
        if value is None:
            raise InputError(self.where, f"{tag}.{attribute}", None, "the attribute is missing")
        return value

    def number(self, tag: str, attribute: str, kind: type = float) -> Any:
        value = self.text(tag, attribute)
        (number,) = read_numbers(self.where, f"{tag}.{attribute}", value, 1)
        if kind is int and not number.is_integer():
            raise InputError(self.where, f"{tag}.{attribute}", value, "give a whole number")
        return kind(number)

    def vector(self, tag: str, attribute: str) -> tuple[float, ...]:
        child = self.element.find(tag)
        value = "0 0 0" if child is None else child.get(attribute, "0 0 0")
        return finite_numbers(self.where, f"{tag}.{attribute}", value, 3, least=0.0)

    def record(self, tag: str, cls: type, **values: float) -> Any:
        """A dataclass filled from the attributes of <tag>; those with a default may be left out."""
        child = self.child(tag)
        attributes = set() if child is None else set(child.keys())
        names = [f.name for f in fields(cls) if f.name not in values and (f.name in attributes or f.default is MISSING)]
        return cls(**values, **{name: self.number(tag, name) for name in names})

    def section(self, tag: str, cls: type[_Section]) -> _Section:
        """A cross-section; the name of a silicone may replace its properties."""
        child = self.child(tag)
        name = None if child is None else child.get("material")
        if child is None or name is None:
            return self.record(tag, cls)
        if name not in SILICONES:
            raise InputError(self.where, f"{tag}.material", name, f"not known; known: {', '.join(SILICONES)}")
        silicone = SILICONES[name]
        silicone_values = {"youngs_modulus": silicone.youngs_modulus, "density": silicone.density}
        for field in silicone_values:
            if child.get(field) is not None:
                raise InputError(self.where, f"{tag}.{field}", child.get(field), "the material sets it; omit one")
        section = self.record(tag, cls, **silicone_values)
        return section

    def columns(self, tag: str) -> list[tuple[float, ...]]:
        """The attributes of <tag>, each a list of numbers; none without <tag>."""
        child = self.child(tag)
        if child is None:
            return []
        names = [name for name in _CHILD_ATTRIBUTES[tag] if name not in _OPTIONAL or child.get(name) is not None]
        return [finite_numbers(self.where, f"{tag}.{name}", self.text(tag, name)) for name in names]

    def elastic_law(self, segment_length: float) -> ElasticLaw | None:
        if self.element.find("elastic_law") is None:
            return None
        angle, base, tip = self.columns("elastic_law")
        return ElasticLaw(tuple(a / (segment_length or 1.0) for a in angle), base, tip)

    def creep(self) -> tuple[CreepBranch, ...]:
        shares, times = self.columns("creep") or [(), ()]
        if len(shares) != len(times):
            raise InputError(self.where, "creep.time", times, "give as many numbers as there are shares")
        return tuple(map(CreepBranch, shares, times))

    def tip_load(self) -> TipLoad | None:
        if self.element.find("tip_load") is None:
            return None
        x, y, z = self.vector("tip_load", "xyz")
        if y != 0:
            raise InputError(self.where, "tip_load.xyz", (x, y, z), "the finger bends in a plane; give 0 for y")
        return TipLoad(self.number("tip_load", "mass"), x, z)

    def paths(self, tag: str) -> tuple[Any, ...]:
        cls = _PATH_CLASSES[tag]
        paths = []
        for child in self.element.findall(tag):
            values: dict[str, Any] = {"name": child.get("name", "")}
            for part in fields(cls):
                text, is_number = child.get(part.name), part.type in (float, "float")
                where = f"{self.where}: {tag} '{values['name']}'"
                if text is None and (part.default is MISSING or part.default == ()):
                    raise InputError(where, part.name, None, "the attribute is missing")
                if text is not None and part.name != "name":
                    numbers = finite_numbers(where, part.name, text, *([1] if is_number else []))
                    values[part.name] = numbers[0] if is_number else numbers
            paths.append(cls(**values))
        return tuple(paths)

    def body(self) -> dict[str, Any]:
        body = self.element.find("body")
        assert body is not None
        numbers = [name for name in _CHILD_ATTRIBUTES["body"] if name != "yields"]
        names = [name for name in numbers if name == "length" or body.get(name) is not None]
        values = {name: self.number("body", name, int if name == "segments" else float) for name in names}
        yields = body.get("yields")
        return values if yields is None else values | {"yields": tuple(yields.split())}


def _check_names(where: str, kind: str, names: list[str], valid_names: list[str]) -> None:
    for name in names:
        if name not in valid_names:
            raise InputError(where, kind, name, f"not known here; {suggestion(name, valid_names)}")
        if names.count(name) > 1 and name not in _REPEATABLE_TAGS:
            raise InputError(where, kind, name, "appears more than once")


def read_finger_element(file: str, element: ET.Element, segments: int | None = None) -> FingerElement:
    """Reads the finger of a <finger> element; `segments` replaces the number in the file.

    Raises:
        InputError: naming file, finger, field and value, if anything is missing, misspelt or out of range.
    """
    reader = _Reader(file, element)
    body = reader.body()
    file_segments = body.get("segments", Finger.segments)
    if segments is not None:
        body["segments"] = segments
    parts = {
        "base": reader.section("base", CrossSection),
        "tip": reader.section("tip", CrossSection),
        "sections": tuple(reader.section(f"section[{i}]", Station) for i in range(len(element.findall("section")))),
        "contact": reader.record("contact", ContactMaterial),
        "sensor_spacing": reader.number("sensors", "spacing"),
        "elastic_law": reader.elastic_law(body["length"] / max(file_segments, 1)),
        "creep": reader.creep(),
        "pressure_law": PressureLaw(*law) if (law := reader.columns("pressure_law")) else None,
        "tip_load": reader.tip_load(),
        "chambers": reader.paths("chamber"),
        "tendons": reader.paths("tendon"),
    }
    mount = (reader.text("parent", "link"), reader.vector("origin", "xyz"), reader.vector("origin", "rpy"))
    try:
        return FingerElement(Finger(reader.name, **body, **parts), *mount)
    except InputError as error:
        field = error.field.replace("sections[", "section[", 1)
        if not field.startswith("section["):
            field = re.sub(r"^(chamber|tendon)s\b", r"\1", re.sub(r"\[\d+\]", "", field))
        expected = _NAMES_IN_FILE.get(field, field), error.value, error.expected
        raise InputError(f"{file}: {error.where}", *expected) from None


def finger_element(mounted: FingerElement) -> ET.Element:
    """The <finger> element of a finger, without default values."""
    finger = mounted.finger
    element = ET.Element("finger", name=finger.name)
    ET.SubElement(element, "parent", link=mounted.parent)
    ET.SubElement(element, "origin", xyz=_text(mounted.xyz), rpy=_text(mounted.rpy))
    numbers = {name: _text(getattr(finger, name)) for name in _BODY_FIELDS}
    yields = " ".join(finger.yields)
    ET.SubElement(element, "body", {"length": _text(finger.length), **numbers, "yields": yields})
    ET.SubElement(element, "base", _attributes(finger.base))
    for section in finger.sections:
        ET.SubElement(element, "section", _attributes(section))
    ET.SubElement(element, "tip", _attributes(finger.tip))
    ET.SubElement(element, "sensors", spacing=_text(finger.sensor_spacing))
    ET.SubElement(element, "contact", _attributes(finger.contact))
    if finger.elastic_law is not None:
        law, ds = finger.elastic_law, finger.segment_length
        angle = _text([ds * curvature for curvature in law.curvature])
        torques = {"base_torque": _text(law.base_moment), "tip_torque": _text(law.tip_moment)}
        ET.SubElement(element, "elastic_law", {"angle": angle, **torques})
    if finger.creep:
        shares, times = zip(*((branch.share, branch.time) for branch in finger.creep), strict=True)
        ET.SubElement(element, "creep", share=_text(shares), time=_text(times))
    if finger.pressure_law is not None:
        ET.SubElement(element, "pressure_law", _attributes(finger.pressure_law))
    if finger.tip_load is not None:
        load = finger.tip_load
        ET.SubElement(element, "tip_load", mass=_text(load.mass), xyz=_text((load.x, 0.0, load.z)))
    for path in (*finger.chambers, *finger.tendons):
        ET.SubElement(element, "chamber" if isinstance(path, Chamber) else "tendon", _attributes(path))
    return element


def _attributes(part: Any) -> dict[str, str]:
    """Fields of a dataclass with other than default values, as text."""
    values = ((parameter, getattr(part, parameter.name)) for parameter in fields(part))
    return {
        parameter.name: _text(value)
        for parameter, value in values
        if parameter.default is MISSING or value != parameter.default
    }


def _text(value: Any) -> str:
    """A value, in full, so that the same finger is read again."""
    if isinstance(value, str):
        return value
    return " ".join(map(_text, value)) if isinstance(value, tuple | list) else repr(value)
