"""A recorded finger at rest at its held steps: its true curve, and what sensors with errors read of it."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.evaluation.paper.contact_table import contact_table, of_touched_fingers
from soft_gripper.evaluation.paper.held_steps import held_samples
from soft_gripper.evaluation.paper.readings_again import ReadAgain, read_again
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

EVERY = 10  # of the held samples, so many apart: they hardly differ but for white noise


@dataclass(frozen=True)
class FingerAtRest:
    """A finger of a recording of T samples, of which K at its held steps are looked at.

    The first sample of a recording is left out: it is there twice, a log at a time still shows the sample before.
    """

    station: Station
    recording: Recording
    finger: PlantFinger

    @property
    def simulated(self) -> Finger:
        """As it is simulated."""
        return self.finger.finger

    @property
    def period(self) -> float:
        """Between samples, s."""
        return self.station.scenario.sensor.period

    @cached_property
    def samples(self) -> NDArray[np.int_]:
        """The K of the T samples."""
        numbers = np.arange(-1.0, len(self.recording["time"]) - 1)
        return held_samples(self.station.scenario, self.recording, numbers)[:, ::EVERY].ravel().astype(int)

    @property
    def pressure(self) -> Array:
        """(T) Pa."""
        return self._again(1).pressure[1:]

    @property
    def gravity(self) -> Planar:
        """In the bending plane, (T) m/s^2."""
        return self._again(1).gravity[1:]

    def readings(self, sections: int, errors: StrainErrors | None, seeds: int) -> Array:
        """What the sensors of `seeds` runs read, (T, seeds, paths * sections)."""
        again = self._again(sections)
        response = again.layout.response
        ratios = np.repeat(response.ratio(again.readings[1:])[:, None], seeds, axis=1)
        rng = np.random.default_rng(sections)
        return response.reading(ratios if errors is None else disturb(errors, ratios, self.period, rng))

    def _again(self, sections: int) -> ReadAgain:
        return read_again(self.station, self.recording, self.finger, sections)

    def points(self, s: Array) -> Planar:
        """The true points of the finger at arc lengths (M) m from the base, (K, M) m in B."""
        q = self.recording[f"{self.finger.name}.sampled_joint_angles"].values[1:][self.samples]
        return points_along(self.simulated, q, s)


def points_along(finger: Finger, q: Array, s: Array) -> Planar:
    """Points of a bent chain at arc lengths (M) m, (..., M) m in B, from joint angles (..., N) rad."""
    chain = forward_kinematics(q, finger.segment_length)
    begins = np.concatenate([np.zeros_like(chain.tip)[..., None], chain.joints], axis=-1)
    link = np.searchsorted(finger.joint_arc_lengths, s)
    points: Planar = begins[..., link] + np.exp(1j * chain.headings[..., link]) * (s - finger.link_ends[link])
    return points


def touched_fingers(name: str, station: Station, recording: Recording) -> Sequence[FingerAtRest]:
    """The fingers of a recording that touch something; all, where none does."""
    contacts = contact_table(name, station, recording)
    touched = {row.finger for row in of_touched_fingers(contacts, contacts)}
    return [FingerAtRest(station, recording, finger) for finger in station.fingers if finger.name in touched]
