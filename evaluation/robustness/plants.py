"""Plants that differ from the shipped finger: model files made from the shipped ones, and scenarios with them."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.loading.model_files import model_path
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.evaluation.robustness.rubber import rubber_moment
from soft_gripper.files import atomic_file
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.xml_text import read_xml

_CURVATURES = np.linspace(-10, 26, 19)  # 1/m, of the points of the elastic law of rubber
_AGREE = 8.7  # 1/m, where rubber is as stiff as it is believed to be: 60 degrees of bend in 120 mm


@dataclass(frozen=True)
class Plant:
    """What of the shipped fingers, and of the scenarios, is different."""

    name: str
    segments: int = 12
    base: Mapping[str, str] = field(default_factory=dict)  # attributes of the sections, as in a <finger>
    tip: Mapping[str, str] = field(default_factory=dict)
    sensors: Mapping[str, str] = field(default_factory=dict)
    rubber: bool = False  # neo-Hookean in the place of linear
    pressure: float = 1.0  # times the pressures of the scenarios
    time_step: float = 0.01  # s
    overrides: Mapping[str, str] = field(default_factory=dict)  # more of a scenario, "dotted.key=value" by its name

    def scenario(self, name: str, folder: Path) -> Scenario:
        """A shipped scenario with these fingers; their files are written to `folder`."""
        shipped = load_scenario(name)
        overrides = [f"plant_config.time_step={self.time_step}"]
        overrides += [self.overrides[name]] if name in self.overrides else []
        for i, model in enumerate(shipped.models):
            if model.file.endswith(".urdf"):
                file = folder / Path(model.file).name
                self.write(model_path(model.file), file)
                overrides.append(f"models.{i}.file={file.resolve()}")
        steps = [self.pressure * step for step in shipped.pressure.steps["all"]]
        limits = [f"pressure.{end}={self.pressure * getattr(shipped.pressure, end)}" for end in ("minimum", "maximum")]
        return load_scenario(name, [*overrides, *limits, f"pressure.steps.all={steps}"])

    def write(self, shipped: Path, file: Path) -> None:
        """Writes a shipped file with these fingers in the place of its own."""
        tree = ET.ElementTree(read_xml(shipped))
        fingers = {finger.name: finger for finger in expand_urdf(shipped).fingers}
        for element in tree.iter("finger"):
            changes = {"body": {"segments": str(self.segments)}}
            changes |= {"base": dict(self.base), "tip": dict(self.tip), "sensors": dict(self.sensors)}
            for tag, attributes in changes.items():
                part = element.find(tag)
                assert part is not None
                part.attrib.update(attributes)
            if self.rubber:
                element.append(_rubber_law(replace(fingers[element.attrib["name"]], segments=self.segments)))
        with atomic_file(file) as partial:
            tree.write(partial)


def _rubber_law(finger: Finger) -> ET.Element:
    """The <elastic_law> of a finger of rubber."""
    angles = _CURVATURES * finger.segment_length
    ends = {"base_torque": finger.base, "tip_torque": finger.tip}
    torques = {name: _text(_moments(section)) for name, section in ends.items()}
    return ET.Element("elastic_law", {"angle": _text(angles), **torques})


def _moments(section: CrossSection) -> Array:
    linear = _AGREE * section.bending_stiffness
    return rubber_moment(section, _CURVATURES) * linear / rubber_moment(section, np.array(_AGREE))


def _text(numbers: Array) -> str:
    return " ".join(f"{number:.9g}" for number in numbers)


_THICK = {"thickness": "0.035", "chamber_thickness": "17.5e-3", "chamber_center": "-1.75e-3"}
_THIN = {"thickness": "0.015", "chamber_thickness": "7.5e-3", "chamber_center": "-0.75e-3"}
# The peg stays as far from the thicker finger, and the pressure bends the stiffer one as far.
_PEG_FARTHER = {"obstructed_outside": "models.1.X_PC.translation=[-0.0685, 0, 0.125]"}
FINE = Plant("24 segments", segments=24)
TAPERED = Plant("tapered", 12, _THICK, _THIN, {"spacing": "0.013"}, pressure=1.2, overrides=_PEG_FARTHER)
RUBBER = Plant("rubber", segments=24, rubber=True, time_step=0.005)
PLANTS = (RUBBER, TAPERED, FINE)
