"""Errors of tip, twist, force and place that designs of sensors leave, by the posterior of a linear-Gaussian model.

Tip and twist are those of the estimator `gaussian`: its prior P about the shape in a task, and readings with slopes H
and variances V there, leave of a quantity with slopes G the covariance

    G (P - P H' (H P H' + V)^-1 H P) G' .

Force and place are those of one push, of which nothing is known but that it is on the finger and as large as usual
loads: with the slopes Q of the joints by its unknowns and by the share b of the drive (`PushedFinger`), and the
deviations of the joints A as further noise,

    (U^-1 + Q' H' (V + H A H')^-1 H Q)^-1 .

Every reading is linearized at the true shape: an estimator that is led astray makes larger errors (`made_errors`).

T tasks, D joints, R readings.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.mechanics import SpatialMechanics
from soft_gripper.estimators.spatial_estimator import Places
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.placement.catalogue import PATHS, STRAIN, Design
from soft_gripper.extras.placement.pushed_finger import UNKNOWNS
from soft_gripper.extras.placement.spatial_tasks import Tasks
from soft_gripper.fingers.finger import Finger

QUANTITIES = ("tip", "twist", "force", "place")


class Errors(NamedTuple):
    """Root mean squares over tasks."""

    tip: float  # m, distance
    twist: float  # rad, of the whole finger
    force: float  # N, across the finger; along a straight one nothing sees it
    place: float  # m, along the finger

    @property
    def score(self) -> float:
        """Geometric mean: a tenth less of any of them counts alike."""
        return float(np.exp(np.mean(np.log(self))))


def errors_of_squares(pose: Array, push: Array) -> Errors:
    """From variances, or squared errors.

    Args:
        pose: of the tip along x, y and z, and of the twist, (..., 4).
        push: of its force across the finger in two directions, and of its place, (..., 3).
    """
    squares = pose[..., :3].sum(axis=-1), pose[..., 3], push[..., :2].sum(axis=-1), push[..., 2]
    return Errors(*(float(np.sqrt(np.mean(square))) for square in squares))


class Seen(NamedTuple):
    """Slopes and variances of the readings near the shapes of all tasks."""

    slopes: Array  # (T, R, D)
    variance: Array  # (T, R)


@dataclass(frozen=True, eq=False)
class Scores:
    """Predicts the errors of designs of one kind of sensor."""

    tasks: Tasks
    kind: str
    uncertainty: Uncertainty
    _seen: dict[Design, Seen] = field(default_factory=dict)  # by single paths

    def __call__(self, design: Design) -> Errors:
        seen = self.seen(design)
        return errors_of_squares(self.pose_variance(seen), self.push_variance(seen))

    def seen(self, design: Design) -> Seen:
        """By all sensors of a design; what is seen along a path does not depend on the others."""
        alone = [Design(design.kind, design.borders, (path,)) for path in design.paths] or [design]
        for one in alone:
            if one not in self._seen:
                self._seen[one] = self._see(one)
        slopes, variance = zip(*(self._seen[one] for one in alone), strict=True)
        return Seen(np.concatenate(slopes, axis=1), np.concatenate(variance, axis=1))

    def pose_variance(self, seen: Seen) -> Array:
        """Variance of the tip along x, y and z, m^2, and of the twist, rad^2, (T, 4)."""
        G, known = self._pose_slopes, seen.slopes @ self._prior
        read = known @ np.swapaxes(seen.slopes, -1, -2) + _diagonal(seen.variance)
        both = known @ np.swapaxes(G, -1, -2)  # (T, R, 4)
        left = ((G @ self._prior) * G).sum(axis=-1) - (both * np.linalg.solve(read, both)).sum(axis=-2)
        return np.asarray(np.maximum(left, 0.0))

    def push_variance(self, seen: Seen) -> Array:
        """Variance of the force of a push across the finger in two directions, N^2, and of its place, m^2, (T', 3)."""
        slopes, variance = (part[self.tasks.is_pushed] for part in seen)
        deviations = slopes @ self._mechanics.deviations @ np.swapaxes(slopes, -1, -2)
        by_push = slopes @ self._push_slopes
        information = np.swapaxes(by_push, -1, -2) @ np.linalg.solve(deviations + _diagonal(variance), by_push)
        std = push_prior(self.tasks.statics.finger, self.uncertainty)
        left = np.linalg.inv(np.eye(len(std)) + std[:, None] * information * std)  # in units of the prior
        found = self._wanted * std
        return np.asarray(((found @ left) * found).sum(axis=-1))

    def _see(self, design: Design) -> Seen:
        layout, q = design.layout(self.tasks.statics.finger), self.tasks.q
        slopes = np.broadcast_to(layout.slopes(q), (len(q), layout.readings, q.shape[-1]))
        assumed = self.uncertainty
        return Seen(slopes, assumed.any_reading**2 + (assumed.gain * layout.predict(q)) ** 2)

    @cached_property
    def _mechanics(self) -> SpatialMechanics:
        """With any sensors of the kind: what is assumed before they are read does not depend on them."""
        paths = tuple(PATHS)[:1] if self.kind == STRAIN else ()
        return SpatialMechanics(Design(self.kind, (), paths).layout(self.tasks.statics.finger), self.uncertainty)

    @cached_property
    def _prior(self) -> Array:
        """Covariance of the joints in all tasks before anything is read, (T, D, D)."""
        tasks = self.tasks
        return self._mechanics.prior(self._mechanics.posture(tasks.q), tasks.q, tasks.driving)

    @cached_property
    def _pose_slopes(self) -> Array:
        """Slopes of tip and twist by the joints, (T, 4, D)."""
        q, statics = self.tasks.q, self.tasks.statics
        moves = Places(statics.finger, statics.ways)(q)[2][..., -1, :]
        twist = np.repeat([way == "twist" for way in statics.ways], statics.finger.segments).astype(float)
        return np.concatenate([np.swapaxes(moves, -1, -2), np.broadcast_to(twist, (len(q), 1, len(twist)))], axis=1)

    @cached_property
    def _wanted(self) -> Array:
        """Combinations of the unknowns of the pushes that are scored, (T', 3, 6)."""
        tasks = self.tasks.pushed
        return wanted_of_push(tasks.statics.across(tasks.q, tasks.push.s))

    @cached_property
    def _push_slopes(self) -> Array:
        """Slopes of the joints by the unknowns of the pushes, (T', D, 6)."""
        tasks = self.tasks.pushed
        return tasks.statics.response(tasks.q, tasks.driving, tasks.push).slopes


def wanted_of_push(across: Array) -> Array:
    """From the unknowns of a push to its force along directions `across`, (..., 2, 3), and its place: (..., 3, 6)."""
    wanted = np.zeros((*across.shape[:-2], 3, len(UNKNOWNS)))
    wanted[..., :2, :3] = across
    wanted[..., 2, 3] = 1.0
    return wanted


def push_prior(finger: Finger, assumed: Uncertainty) -> Array:
    """Standard deviations of the unknowns of a push before anything is read, (6,).

    A force as large as a usual load, anywhere along the finger and across it, and the share of the drive.
    """
    force = assumed.load_pressure * finger.pressure_gain.max() / finger.length
    width = min(float(section.width) for section in finger.cross_sections)
    places = finger.length / np.sqrt(12), width / np.sqrt(12)
    return np.array([force, force, force, *places, assumed.bend_per_pressure])


def _diagonal(values: Array) -> Array:
    return values[..., None] * np.eye(values.shape[-1])
