"""Errors that a design of sensors leaves: as its estimator states them, and as it makes them.

Both are of the estimators that ship. `contact` states with every estimate the covariance of the shape, which is that of
`gaussian`, and the standard deviations of force and place; what it states of sensors without errors is the prediction,
which needs no random numbers. For the errors that are made, sensors with errors read the way to every sample, in
several sets, and the nominal finger is once too stiff and once too soft.

M samples, S sets of sensors, P joints and tip, D joint positions.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.finger_shape import Places
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.extras.placement.catalogue import PATHS, STRAIN, Design, errors_of, leaves_its_plane
from soft_gripper.extras.placement.samples import Samples
from soft_gripper.extras.studies.contacts.found_contact import FoundContact
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.nominal_model import NominalModel
from soft_gripper.scenario.schema import NominalConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel, ways_in_space
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

SETS = 8  # of sensors to draw if they have errors
RANKING = "contact"  # the estimator by which designs are ranked


class Errors(NamedTuple):
    """Root mean squares over samples; NaN where there is none."""

    pose: float  # m, distance of joints and tip
    twist: float  # rad, of the whole finger
    force: float  # N, along the normal of the face
    place: float  # m, along the finger

    @property
    def score(self) -> float:
        """Geometric mean of those that there are: a tenth less of any of them counts alike."""
        return float(np.exp(np.nanmean(np.log(np.maximum(self, 1e-12)))))


@dataclass(frozen=True)
class Assumptions:
    """The errors of all kinds of sensors, and by how much the nominal stiffness is wrong.

    Raises:
        InputError: if the nominal finger would be impossible.
    """

    preset: str | None = None  # of the errors of strain sensors; None: all kinds are ideal
    nominal_error: float = 0.0  # %, of Young's modulus, up and down
    seed: int = 1  # of what is random

    def __post_init__(self) -> None:
        if not 0 <= self.nominal_error < 100:
            expected = "give a percentage from 0 to below 100"
            raise InputError("place-sensors", "--nominal-error", self.nominal_error, expected)

    def errors(self, kind: str) -> StrainErrorsConfig | None:
        """Errors of sensors of a kind."""
        return errors_of(kind, self.preset)

    def strain_errors(self, kind: str) -> StrainErrors | None:
        """Errors of readings as sensors have them."""
        return strain_errors(SensorConfig(errors=self.errors(kind)))

    def uncertainty(self, kind: str) -> Uncertainty:
        """The sizes of these errors that the estimator assumes."""
        return uncertainty_of(self.strain_errors(kind), finger=self.nominal_error / 100)

    def nominal(self, finger: Finger) -> list[Finger]:
        """The nominal finger, once too stiff and once too soft."""
        signs = (1, -1) if self.nominal_error else (1,)
        changes = [NominalConfig(youngs_modulus=f"{sign * self.nominal_error:+g} %") for sign in signs]
        return [NominalModel(change).finger(finger) for change in changes]


class _Squares(NamedTuple):
    """Squares of errors, any shape; NaN where there is none."""

    pose: Array
    twist: Array
    force: Array
    place: Array


@dataclass(frozen=True)
class Judge:
    """Judges designs by samples."""

    samples: Sequence[Samples]
    assumptions: Assumptions

    def check(self, estimator: str) -> None:
        """Raises an InputError unless an estimator of that name is for such fingers."""
        paths = (next(iter(PATHS)),) if leaves_its_plane(self.samples[0].finger) else ()
        layout = _layout(Design(STRAIN, (), paths), self.samples[0])
        estimator_function(estimator, layout, self.assumptions.uncertainty(STRAIN))

    def predicted(self, design: Design) -> Errors:
        """The errors that `contact` states, of sensors without errors on the nominal finger."""
        assumed = self.assumptions.uncertainty(design.kind)
        return _root_mean(_stated(samples, _layout(design, samples), assumed) for samples in self.samples)

    def made(self, design: Design, estimator: str, number: int) -> dict[str, Errors]:
        """The errors that an estimator makes, by run; `number` of the design: each has random numbers of its own."""
        found: dict[str, list[_Squares]] = {}
        for i, samples in enumerate(self.samples):
            rng = np.random.default_rng([self.assumptions.seed, number, i])
            found.setdefault(samples.run, []).extend(self._made(design, estimator, samples, rng))
        return {run: _root_mean(iter(squares)) for run, squares in found.items()}

    def _made(self, design: Design, estimator: str, samples: Samples, rng: np.random.Generator) -> Iterator[_Squares]:
        layout, errors = _layout(design, samples), self.assumptions.strain_errors(design.kind)
        readings = _read(layout, samples, errors, rng)
        for nominal in self.assumptions.nominal(samples.finger):
            known = sensor_layout(nominal, design.config(nominal, samples.sensor))
            function = estimator_function(estimator, known, self.assumptions.uncertainty(design.kind))
            driving = np.repeat(samples.driving(nominal)[None], len(readings), axis=0)
            gravity = np.broadcast_to(samples.contacts.gravity, (*readings.shape[:-1], 3))
            yield _made(samples, function(readings, driving, gravity))


def _layout(design: Design, samples: Samples) -> MeasurementModel:
    return sensor_layout(samples.finger, design.config(samples.finger, samples.sensor))


def _stated(samples: Samples, layout: MeasurementModel, assumed: Uncertainty) -> _Squares:
    """Variances that `contact` states of exact readings; all of a force, and a place anywhere, where it knows none."""
    contacts, finger = samples.contacts, samples.finger
    estimate = estimator_function(RANKING, layout, assumed)
    shape = estimate(layout.read(contacts.q), samples.driving(finger), contacts.gravity)
    assert shape.covariance is not None
    pose = Places(finger, layout.ways).variance(shape.q, shape.covariance).sum(axis=-1).mean(axis=-1)
    turns = _twist(finger)
    twist = (turns @ shape.covariance * turns).sum(axis=-1) if turns.any() else np.full(len(pose), np.nan)
    found = FoundContact.of(shape.contact, contacts, leaves_its_plane(finger))
    force = np.where(np.isfinite(found.force_std), found.force_std, contacts.normal_force)
    return _Squares(pose, twist, *_touched(samples, force**2, found.arc_length_std**2))


def _made(samples: Samples, shape: ShapeEstimate) -> _Squares:
    """Squared errors of estimates, (S, M)."""
    finger, contacts = samples.finger, samples.contacts
    places, turns = Places(finger, ways_in_space(finger)), _twist(finger)
    pose = ((places(shape.q)[0] - places(contacts.q)[0]) ** 2).sum(axis=-1).mean(axis=-1)
    twist = ((shape.q - contacts.q) @ turns) ** 2 if turns.any() else np.full(pose.shape, np.nan)
    if shape.contact is None:
        return _Squares(pose, twist, np.full(pose.shape, np.nan), np.full(pose.shape, np.nan))
    found = FoundContact.of(shape.contact, contacts, leaves_its_plane(finger))
    force = np.nan_to_num(found.force) - contacts.normal_force
    return _Squares(pose, twist, *_touched(samples, force**2, (found.arc_length - contacts.arc_length) ** 2))


def _touched(samples: Samples, force: Array, place: Array) -> tuple[Array, Array]:
    """Errors of the samples that are touched; a place that is not found may be anywhere."""
    anywhere = np.where(np.isfinite(place), place, samples.finger.length**2 / 12)
    return np.where(samples.touched, force, np.nan), np.where(samples.touched, anywhere, np.nan)


def _twist(finger: Finger) -> Array:
    """Which joint positions add up to the twist, (D)."""
    return np.repeat([way == "twist" for way in ways_in_space(finger)], finger.segments).astype(float)


def _read(layout: MeasurementModel, samples: Samples, errors: StrainErrors | None, rng: np.random.Generator) -> Array:
    """Readings of the held samples by sets of sensors, which have seen the way there, (S, M, R)."""
    if errors is None:
        return layout.read(samples.contacts.q)[None]
    ideal = 1 + layout.predict(samples.way)[:, None]  # (T, 1, F, R)
    read = disturb(errors, np.repeat(ideal, SETS, axis=1), samples.sensor.period, rng)[samples.held]
    readings = np.moveaxis(layout.response.reading(read), 1, 0)
    return readings.reshape(SETS, -1, readings.shape[-1])


def _root_mean(squares: Iterator[_Squares]) -> Errors:
    """Every part counts alike, by the mean over its samples."""
    means = [[float(np.nanmean(each)) if np.isfinite(each).any() else np.nan for each in part] for part in squares]
    return Errors(
        *(float(np.sqrt(np.nanmean(each))) if np.isfinite(each).any() else np.nan for each in np.array(means).T)
    )
