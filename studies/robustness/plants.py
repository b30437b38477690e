"""Plants that differ from the shipped finger: model files made from the shipped ones, and scenarios with them.

The moment of a section of rubber, which replaces E I times the curvature where strains are large.

A neo-Hookean silicone of the small-strain modulus E, stretched by lambda along the finger and free across it, has the
engineering stress

    sigma = E / 3 (lambda - 1 / lambda^2)

(Treloar, The Physics of Rubber Elasticity, 1975, ch. 4): it softens in tension and stiffens in compression. With plane
sections, lambda = 1 - kappa (x - x_n) at x, and the moment about the neutral axis x_n, which the strain-limiting layer
holds in place, is the integral of -sigma (x - x_n) over the section.

Only the plants are simulated anew; errors of sensors are applied to recordings, since sensors do not affect what they
measure. The plants differ from the nominal model in segments, elastic law and time step, so that no estimator is
right because it is wrong in the same way as the plant.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.contact_table import contact_table, touched_finger_rows
from soft_gripper.files.output import atomic_file
from soft_gripper.files.xml_text import read_xml
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.runs.scores.poses import held_rows
from soft_gripper.runs.scores.readings import ReadAgain, read_again
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import changed_scenario, load_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.strain_errors import StrainErrors, disturb
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, corners
from studies.contacts.contacts import FINGER

_STRIPS = 400


def rubber_moment(section: CrossSection, curvature: Array) -> Array:
    """Bending moments, N m, at curvatures (...) 1/m, positive where the finger closes."""
    silicone = section.thickness - section.layer_thickness
    strip = silicone / _STRIPS
    x = -section.thickness / 2 + strip * (np.arange(_STRIPS) + 0.5)
    hollow = np.abs(x - section.chamber_center) < section.chamber_thickness / 2
    width, lever = section.width - hollow * section.chamber_width, x - section.neutral_axis
    stretch = 1 - curvature[..., None] * lever
    stress = section.youngs_modulus / 3 * (stretch - stretch**-2)
    off_axis = section.layer_center - section.neutral_axis
    of_layer = section.layer_thickness**2 / 12 + off_axis**2
    layer = section.layer_modulus * section.width * section.layer_thickness * of_layer
    moment: Array = -(stress * lever * width).sum(axis=-1) * strip + layer * curvature
    return moment


_CURVATURES = np.linspace(-10, 26, 19)  # 1/m, of the points of the elastic law of rubber
_AGREE = 8.7  # 1/m, where rubber is as stiff as nominal: 60 degrees of bend in 120 mm


@dataclass(frozen=True)
class Plant:
    """The differences from the shipped fingers and scenarios."""

    name: str
    segments: int = 12
    base: Mapping[str, str] = field(default_factory=dict)  # attributes of the sections, as in a <finger>
    tip: Mapping[str, str] = field(default_factory=dict)
    sensors: Mapping[str, str] = field(default_factory=dict)
    rubber: bool = False  # neo-Hookean instead of linear
    pressure: float = 1.0  # times the pressures of the scenarios
    time_step: float = 0.01  # s
    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # more, by dotted keys, of each scenario

    def scenario(self, name: str, folder: Path) -> Scenario:
        """A shipped scenario with these fingers; their files are written to `folder`."""
        shipped = load_scenario(name)
        changes: dict[str, Any] = {"plant_config.time_step": self.time_step, **self.changes.get(name, {})}
        for i, model in enumerate(shipped.models):
            if model.file.endswith(".urdf"):
                file = folder / Path(model.file).name
                self.write(model_path(model.file), file)
                changes[f"models.{i}.file"] = str(file.resolve())
        for end in ("minimum", "maximum"):
            changes[f"pressure.{end}"] = self.pressure * getattr(shipped.pressure, end)
        changes["pressure.steps.all"] = [self.pressure * step for step in shipped.pressure.steps["all"]]
        return changed_scenario(name, changes)

    def finger(self) -> Finger:
        """The shipped finger of a single finger's file with these differences."""
        with TemporaryDirectory(prefix="soft-gripper-") as folder:
            file = Path(folder) / "finger.urdf"
            self.write(model_path(FINGER), file)
            (finger,) = expand_urdf(file).fingers
        return finger

    def write(self, shipped: Path, file: Path) -> None:
        """Writes a shipped file in which these fingers replace its own."""
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
_PEG_FARTHER = {"obstructed_outside": {"models.1.X_PC.translation": [-0.0685, 0, 0.125]}}
FINE = Plant("24 segments", segments=24)
TAPERED = Plant("tapered", 12, _THICK, _THIN, {"spacing": "0.013"}, pressure=1.2, changes=_PEG_FARTHER)
RUBBER = Plant("rubber", segments=24, rubber=True, time_step=0.005)
PLANTS = (RUBBER, TAPERED, FINE)


EVERY = 10  # of the held samples, so far apart: they hardly differ except in white noise


@dataclass(frozen=True)
class FingerAtRest:
    """A finger of a recording with T samples, of which K at its held steps are used."""

    station: Station
    recording: Recording
    finger: PlantFinger

    @property
    def simulated(self) -> Finger:
        """The simulated finger."""
        return self.finger.finger

    @property
    def period(self) -> float:
        """Between samples, s."""
        return self.station.scenario.sensor.period

    @cached_property
    def samples(self) -> NDArray[np.int_]:
        """The K of the T samples."""
        rows = held_rows(self.station.scenario, self.recording)[:, ::EVERY]
        return self.recording.sample_numbers[rows].ravel()

    @property
    def pressure(self) -> Array:
        """(T) Pa."""
        return self._again(1).pressure

    @property
    def gravity(self) -> Array:
        """In B, (T, 3) m/s^2."""
        return self._again(1).gravity

    def readings(self, sections: int, errors: StrainErrors | None, seeds: int) -> Array:
        """Readings of the sensors of `seeds` runs, (T, seeds, paths * sections)."""
        again = self._again(sections)
        response = again.layout.response
        ratios = np.repeat(response.ratio(again.readings)[:, None], seeds, axis=1)
        rng = np.random.default_rng(sections)
        return response.reading(ratios if errors is None else disturb(errors, ratios, self.period, rng))

    def _again(self, sections: int) -> ReadAgain:
        return read_again(self.station, self.recording, self.finger, sections)

    def points(self, s: Array) -> Array:
        """The true points of the finger at arc lengths (M) m from the base, (K, M, 3) m in B."""
        names = (f"{self.finger.name}.{name}" for name in (TRUE_JOINTS, TRUE_TIP))
        joints, tip = (self.recording.samples(name)[self.samples] for name in names)
        return points_along(self.simulated, corners(joints, tip), s)


def touched_fingers(name: str, station: Station, recording: Recording) -> Sequence[FingerAtRest]:
    """The fingers of a recording that touch something; all of them if none does."""
    contacts = contact_table(name, station, recording)
    touched = {row.finger for row in touched_finger_rows(contacts, contacts)}
    return [FingerAtRest(station, recording, finger) for finger in station.fingers if finger.name in touched]


def points_along(finger: Finger, corners: Array, s: Array) -> Array:
    """Points at arc lengths (M) m from the base, (..., M, 3) m, of links from corner to corner, (..., N + 2, 3) m."""
    link = np.searchsorted(finger.joint_arc_lengths, s)
    share = (s - finger.link_ends[link]) / np.diff(finger.link_ends)[link]
    begins = corners[..., link, :]
    points: Array = begins + share[:, None] * (corners[..., link + 1, :] - begins)
    return points
