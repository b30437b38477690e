"""CalibratedStates: the states of a calibration, and the uncertainty of the nominal model away from them.

A state is that of a finger that bends freely: what its sensors read, as strains, and what drives it: the torque at its
first joint, and gravity in its bending plane. Errors of the sensors of a section go with what these read, those of the
drive with what drives the finger. A contact changes the readings under the same drive, so both distances are taken by
themselves (`fitted_states`): a reading in section s is within

    sqrt(floor^2 + growth^2 (d_drive + d_s))

of that of the nominal model with a probability of 95 %. What is due to the drive, and the floor, which the calibration
leaves, count as an error of the pressure.

Leading axes are free; R readings, path after path, S sections; 3 numbers of the drive.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.sensors.fitted_states import FittedStates, Widths, spread_of

DRIVE = 3  # numbers of a state that drive a finger, last: torque, N m; gravity along x and z of B, m/s^2
NORMAL_95 = 1.96  # standard deviations, within which 95 % lie
KNOWN_DRIVE = 0.1  # spreads from the nearest fitted state, within which a drive is known
_GRAVITY_SCALE = 9.81  # m/s^2, unit of gravity: a calibration often has a single pose


class StateDistances(NamedTuple):
    """Distances from the states of a calibration, in spreads."""

    drive: Array  # (...)
    sections: Array  # (..., S) beyond their noise; 0 of a section that is not read
    # (...) of drive and readings together, where the drive is known; NaN elsewhere, and where not all is read
    agreement: Array


@dataclass(frozen=True, eq=False)
class CalibratedStates:
    """The states of a finger's calibration; its sensors have S sections."""

    fitted: FittedStates  # (n, R + 3)
    widths: Widths  # of each strain that is read, (1,)
    disagreement: float  # spreads, within which readings and drive agree; infinite: it is not known
    sections: int
    noise: float = 0.0  # spreads, by which single samples of a section are away from where it rests
    # Standard deviation of the bend, as a share: readings and pressure alone cannot tell a finger that bends further
    # from sensors that all read as much more
    bend_std: float = 0.0
    variation_std: float = 0.0  # likewise of its change from the middle of the finger to the tip
    # Standard deviation of a reading that calibration leaves, as a share of the strain; None: it does not say
    gain_std: float | None = None

    def distances(self, strains: Array, driving: Array, gravity: Array) -> StateDistances:
        """Distances of samples from strains, (..., R), NaN where nothing is read, and the drive.

        `driving` is the torque at the joints, (..., D) N m: the first counts. `gravity` is in B, (..., 3) m/s^2.
        """
        drive = np.stack(np.broadcast_arrays(driving[..., 0], gravity[..., 0], gravity[..., 2]), axis=-1)
        drive_distance = self._drive.distance(drive)
        is_read = np.isfinite(strains)
        filled = np.where(is_read, strains, 0.0)
        columns = [
            np.where(is_read[..., readings].all(axis=-1), section_states.distance(filled[..., readings]), 0.0)
            for readings, section_states in self._columns
        ]
        section_distances = np.maximum(np.stack(columns, axis=-1) - self.noise, 0.0)
        are_usable = is_read.all(axis=-1) & (drive_distance < KNOWN_DRIVE)
        shape = np.broadcast_shapes(filled.shape[:-1], drive.shape[:-1])
        states = [np.broadcast_to(part, (*shape, part.shape[-1])) for part in (filled, drive)]
        joint = self.fitted.distance(np.concatenate(states, axis=-1))
        return StateDistances(drive_distance, section_distances, np.where(are_usable, joint, np.nan))

    def state_distances(self, states: Array) -> StateDistances:
        """Distances of whole states, (..., R + 3)."""
        drive = states[..., -DRIVE:]
        gravity = np.stack([drive[..., 1], np.zeros_like(drive[..., 1]), drive[..., 2]], axis=-1)
        return self.distances(states[..., :-DRIVE], drive[..., :1], gravity)

    def errors(self, distances: StateDistances) -> tuple[Array, Array]:
        """Standard deviations of the errors of strains.

        Returns that of the drive, (...), in the strain that it changes most, and those of the sections, (..., S).
        """
        drive_std = self.widths.band(np.sqrt(distances.drive)[..., None])[..., 0]
        return drive_std / NORMAL_95, self.widths.growth / NORMAL_95 * np.sqrt(distances.sections)

    def is_far(self, distances: StateDistances) -> NDArray[np.bool_]:
        """Mask of samples with a band that is wider by the distances than by all else, (...)."""
        return self.widths.is_far(distance_stds(distances, self.paths)).any(axis=-1)

    @property
    def paths(self) -> int:
        """Number of measured paths, each with a reading for every section."""
        return (self.fitted.states.shape[-1] - DRIVE) // self.sections

    @property
    def spaces(self) -> list[FittedStates]:
        """The states of the drive, and those of every section."""
        return [self._drive, *(states for _, states in self._columns)]

    @cached_property
    def _drive(self) -> FittedStates:
        return self.fitted.part(slice(-DRIVE, None))

    @cached_property
    def _columns(self) -> list[tuple[NDArray[np.int_], FittedStates]]:
        """Lists the readings of every section with their states."""
        readings = np.arange(self.paths * self.sections).reshape(-1, self.sections).T
        return [(section_readings, self.fitted.part(section_readings)) for section_readings in readings]


def distance_stds(distances: StateDistances, paths: int) -> Array:
    """Standard deviations of the readings by their distances, for a growth of 1, (..., R)."""
    section_stds = np.sqrt(distances.drive[..., None] + distances.sections)
    return np.concatenate([section_stds] * paths, axis=-1)


def state_spreads(strains: Array, drive: Array) -> Array:
    """Units of the numbers of states, (R + 3,), from strains, (n, R), and drives, (n, 3)."""
    drive_spreads = [spread_of(drive[:, :1]), _GRAVITY_SCALE, _GRAVITY_SCALE]
    return np.array([spread_of(strains)] * strains.shape[-1] + drive_spreads)
