"""A recorded finger at rest at its held steps: its true curve, and what sensors with errors read of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.evaluation.paper.contact_table import contact_table, of_touched_fingers
from soft_gripper.evaluation.paper.held_steps import held_samples
from soft_gripper.evaluation.paper.readings_again import read_again
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

EVERY = 10  # of the held samples, so many apart: they hardly differ but for white noise


@dataclass(frozen=True)
class HeldFinger:
    """A finger of a recording of T samples, of which K at its held steps are looked at."""

    station: Station
    recording: Recording
    finger: PlantFinger

    @property
    def simulated(self) -> Finger:
        """As it is simulated."""
        return self.finger.finger

    @property
    def samples(self) -> NDArray[np.int_]:
        """The K samples."""
        every = np.arange(len(self.recording["time"]))
        return held_samples(self.station.scenario, self.recording, every)[:, ::EVERY].ravel()

    @property
    def pressure(self) -> Array:
        """(K) Pa."""
        return read_again(self.station, self.recording, self.finger, 1).pressure[self.samples]

    @property
    def gravity(self) -> Planar:
        """In the bending plane, (K) m/s^2."""
        return read_again(self.station, self.recording, self.finger, 1).gravity[self.samples]

    def readings(self, sections: int, errors: StrainErrors | None, seeds: int) -> Array:
        """What the sensors of `seeds` runs read, (K, seeds, paths * sections); without errors they are all the same.

        The errors go through the whole recording, since sensors remember.
        """
        again = read_again(self.station, self.recording, self.finger, sections)
        if errors is None:
            return np.repeat(again.readings[self.samples, None], seeds, axis=1)
        response = again.layout.response
        ratios = np.repeat(response.ratio(again.readings)[:, None], seeds, axis=1)
        rng = np.random.default_rng(sections)
        disturbed = disturb(errors, ratios, self.station.scenario.sensor.period, rng)
        return response.reading(disturbed[self.samples])

    def points(self, s: Array) -> Planar:
        """The true points of the finger at arc lengths (M) m from the base, (K, M) m in B."""
        q = self.recording[f"{self.finger.name}.sampled_joint_angles"].values[self.samples]
        return points_along(self.simulated, q, s)


def points_along(finger: Finger, q: Array, s: Array) -> Planar:
    """Points of a bent chain at arc lengths (M) m, (..., M) m in B, from joint angles (..., N) rad."""
    chain = forward_kinematics(q, finger.segment_length)
    begins = np.concatenate([np.zeros_like(chain.tip)[..., None], chain.joints], axis=-1)
    link = np.searchsorted(finger.joint_arc_lengths, s)
    points: Planar = begins[..., link] + np.exp(1j * chain.headings[..., link]) * (s - finger.link_ends[link])
    return points


def touched_fingers(name: str, station: Station, recording: Recording) -> Sequence[HeldFinger]:
    """The fingers of a recording that touch something; all, where none does."""
    contacts = contact_table(name, station, recording)
    touched = {row.finger for row in of_touched_fingers(contacts, contacts)}
    return [HeldFinger(station, recording, finger) for finger in station.fingers if finger.name in touched]
