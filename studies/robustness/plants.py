"""Plants that differ from the shipped finger, scenarios with them, and fingers at rest in their recordings.

In: a shipped scenario. Out: the scenario with other fingers, and `FingerAtRest` of its recording. Another plant is an
entry of PLANTS with its function of the shipped finger.

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

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.paper.contact_table import contact_table, touched_finger_rows
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.urdf import changed_urdf
from soft_gripper.runs.scores.poses import held_rows
from soft_gripper.runs.scores.readings import ReadAgain, read_again
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import changed_scenario, load_scenario
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

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
    layer_moment = section.layer_thickness**2 / 12 + off_axis**2
    layer = section.layer_modulus * section.width * section.layer_thickness * layer_moment
    return -(stress * lever * width).sum(axis=-1) * strip + layer * curvature


_CURVATURES = np.linspace(-10, 26, 19)  # 1/m, of the points of the elastic law of rubber
_NOMINAL_CURVATURE = 8.7  # 1/m, where rubber is as stiff as nominal: 60 degrees of bend in 120 mm


def _rubber_finger(finger: Finger) -> Finger:
    """The finger with the elastic law of rubber in twice the segments."""

    def moments(section: CrossSection) -> tuple[float, ...]:
        linear = _NOMINAL_CURVATURE * section.bending_stiffness
        moments = rubber_moment(section, _CURVATURES) * linear / rubber_moment(section, np.array(_NOMINAL_CURVATURE))
        return tuple(moments.tolist())

    law = ElasticLaw(tuple(_CURVATURES.tolist()), moments(finger.base), moments(finger.tip))
    return replace(finger, segments=24, elastic_law=law)


def _tapered_finger(finger: Finger) -> Finger:
    base, tip = (
        replace(section, thickness=thickness, chamber_thickness=thickness / 2, chamber_center=-thickness / 20)
        for section, thickness in ((finger.base, 0.035), (finger.tip, 0.015))
    )
    return replace(finger, base=base, tip=tip, sensor_spacing=0.013)


@dataclass(frozen=True)
class Plant:
    """The differences from the shipped fingers and scenarios."""

    name: str
    finger: Callable[[Finger], Finger]  # from the shipped one
    is_known: bool = True  # whether the nominal finger is this one, and sensors are ideal
    pressure: float = 1.0  # times the pressures of the scenarios
    time_step: float = 0.01  # s
    changes: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  # more, by dotted keys, of each scenario

    def scenario(self, name: str, folder: Path) -> Scenario:
        """A shipped scenario with these fingers; their files are written to `folder`."""
        shipped_scenario = load_scenario(name)
        changes: dict[str, Any] = {"plant_config.time_step": self.time_step, **self.changes.get(name, {})}
        for i, model in enumerate(shipped_scenario.models):
            if model.file.endswith(".urdf"):
                file = folder / Path(model.file).name
                text = changed_urdf(model_path(model.file), change=lambda m: replace(m, finger=self.finger(m.finger)))
                file.write_text(text, encoding="utf-8")
                changes[f"models.{i}.file"] = str(file.resolve())
        for end in ("minimum", "maximum"):
            changes[f"pressure.{end}"] = self.pressure * getattr(shipped_scenario.pressure, end)
        changes["pressure.steps.all"] = [self.pressure * step for step in shipped_scenario.pressure.steps["all"]]
        return changed_scenario(name, changes)


# The peg stays as far from the thicker finger, and the pressure bends the stiffer one as far.
_FARTHER_PEG = {"obstructed_outside": {"models.1.X_PC.translation": [-0.0685, 0, 0.125]}}
FINE = Plant("24 segments", lambda finger: replace(finger, segments=24))
TAPERED = Plant("tapered", _tapered_finger, pressure=1.2, changes=_FARTHER_PEG)
RUBBER = Plant("rubber", _rubber_finger, is_known=False, time_step=0.005)
PLANTS = (RUBBER, TAPERED, FINE)


EVERY = 10  # of the held samples, so far apart: they hardly differ except in white noise


@dataclass(frozen=True)
class FingerAtRest:
    """A finger of a recording with T samples; K of them, at its held steps, are used."""

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
        """Numbers of the K samples among the T."""
        rows = held_rows(self.station.scenario, self.recording)[:, ::EVERY]
        return self.recording.sample_numbers[rows].ravel()

    @property
    def pressure(self) -> Array:
        """Pressure in the chamber, (T) Pa."""
        return self._sensors(1).pressure

    @property
    def gravity(self) -> Array:
        """Gravity in B, (T, 3) m/s^2."""
        return self._sensors(1).gravity

    def readings(self, sections: int, errors: StrainErrors | None, seeds: int) -> Array:
        """Readings of the sensors of `seeds` runs, (T, seeds, paths * sections)."""
        sensors = self._sensors(sections)
        response = sensors.layout.response
        ratios = np.repeat(response.ratio(sensors.readings)[:, None], seeds, axis=1)
        rng = np.random.default_rng(sections)
        return response.reading(ratios if errors is None else disturb(errors, ratios, self.period, rng))

    def _sensors(self, sections: int) -> ReadAgain:
        return read_again(self.station, self.recording, self.finger, sections)

    def points(self, s: Array) -> Array:
        """The true points of the finger at arc lengths (M) m from the base, (K, M, 3) m in B."""
        q = self.recording.samples(f"{self.finger.name}.sampled_joint_angles")[self.samples]
        return in_space(forward_kinematics(q, self.simulated.segment_length).sites(s).points)


def touched_fingers(name: str, station: Station, recording: Recording) -> Sequence[FingerAtRest]:
    """The fingers of a recording that touch something; all of them if none does."""
    contacts = contact_table(name, station, recording)
    names = {row.finger for row in touched_finger_rows(contacts, contacts)}
    return [FingerAtRest(station, recording, finger) for finger in station.fingers if finger.name in names]
